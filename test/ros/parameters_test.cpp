// The table of parameters binds each name to an option of its own, with the core's default and the words the core
// knows. All values that it offers work, or are refused with a sentence.
#include <gms_ransac/MatchFilterConfig.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "methods/method.h"
#include "node/reconfigure.h"

namespace gms_ransac {
namespace {

const Parameter& row(const std::string& name) {
  for (const Parameter& parameter : coreParameters()) {
    if (parameter.name == name) return parameter;
  }
  throw std::out_of_range(name);
}

/// As dynamic_reconfigure has them at their defaults.
ParameterValues window() {
  dynamic_reconfigure::Config message;
  MatchFilterConfig::__getDefault__().__toMessage__(message);
  return valuesOf(message);
}

/// `options` without a change have the defaults of the table, and so has the reconfigure file. Returns its parameters.
template <class Options>
size_t expectDefaults(const ParameterTable& table, const Options& options) {
  const ParameterValues live = window(), fields = parametersOf(options);
  size_t found = 0;
  for (const Parameter& parameter : table) {
    const auto field = fields.find(parameter.name), value = live.find(parameter.name);
    EXPECT_EQ(field == fields.end(), parameter.name.find('/') != std::string::npos) << parameter.name;
    EXPECT_TRUE(field == fields.end() || field->second == parameter.default_value) << parameter.name;
    if (value == live.end()) continue;
    EXPECT_EQ(value->second, parameter.default_value) << parameter.name;
    ++found;
  }
  return found;
}

TEST(Parameters, OffersEveryMethodAndNoOther) {
  std::set<std::string> known;
  for (const MethodEntry& method : methods()) known.insert(method.name);
  const std::vector<std::string>& offered = row("method").choices;
  EXPECT_EQ(std::set<std::string>(offered.begin(), offered.end()), known);
}

TEST(Parameters, OffersOnlyWordsTheCoreTakes) {
  for (const Parameter& parameter : coreParameters()) {
    for (const std::string& word : parameter.choices) {
      MatchFilterOptions options;
      setParameters({{parameter.name, word}}, options);
      EXPECT_NO_THROW(MatchFilter{options}) << parameter.name << " " << word;
      EXPECT_EQ(parametersOf(options).at(parameter.name), ParameterValue(word)) << parameter.name;
    }
  }
}

TEST(Parameters, DefaultsAreTheFieldsAndTheReconfigureFiles) {
  const size_t of_core = expectDefaults(coreParameters(), MatchFilterOptions()),
               live = expectDefaults(liveParameters(), RuntimeOptions());
  EXPECT_EQ(live, window().size());
  EXPECT_EQ(live - of_core, liveParameters().size() - coreParameters().size());
  EXPECT_EQ(expectDefaults(startParameters(), Parameters()), 0u);
}

TEST(Parameters, TheWindowIsForRobotsAndTheRestIsSetAtStart) {
  EXPECT_LE(window().size(), 30u);
  RuntimeOptions options;
  options.processor.core.robust.seed = 7;
  options.processor.core.extractor.features = 300;
  setParameters(window(), options);
  EXPECT_EQ(options.processor.core.robust.seed, 7u);
  EXPECT_EQ(options.processor.core.extractor.features, 2000);
}

TEST(Parameters, AChangeNamesAllThatItRefuses) {
  RuntimeOptions options;
  try {
    setParameters({{"features", 0}, {"overlay_colour", std::string("depth")}, {"max_frame_gap", -1.}}, options,
                  "parameter ~");
    FAIL() << "taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "parameter ~features is '0'; it must be a whole number between 1 and 100000; "
                 "parameter ~max_frame_gap is '-1'; it must be a number between 0.001 and 3600 seconds");
  }
  EXPECT_EQ(options.outputs.overlay.colour, OverlayOptions().colour) << "nothing changes";
}

TEST(Parameters, EachSetsAnOptionOfItsOwn) {
  for (const Parameter& parameter : coreParameters()) {
    ParameterValue value = parameter.default_value;
    if (auto* flag = std::get_if<bool>(&value)) *flag = !*flag;
    if (auto* whole = std::get_if<int>(&value)) *whole = static_cast<int>(parameter.high);
    if (auto* number = std::get_if<double>(&value)) *number = parameter.high;
    if (auto* word = std::get_if<std::string>(&value)) {
      *word = parameter.choices.front() == *word ? parameter.choices.back() : parameter.choices.front();
    }
    MatchFilterOptions options;
    setParameters({{parameter.name, value}}, options);
    ParameterValues expected = parametersOf(MatchFilterOptions());
    expected[parameter.name] = value;
    EXPECT_EQ(parametersOf(options), expected) << parameter.name;
    EXPECT_NO_THROW(options.validate()) << parameter.name;
  }
}

TEST(Parameters, NotSetAndTheGapBeforeTheRange) {
  MatchFilterOptions options;
  setParameters({{"gms_grid_columns", 30}, {"inlier_threshold_px", 2.5}, {"sort_key", std::string("score")}}, options);
  EXPECT_EQ(options.motion_statistics.grid_columns, 30);
  EXPECT_EQ(options.robust.inlier_threshold_px, 2.5);
  EXPECT_EQ(options.robust.sort_key, SortKey::kScore);
  setParameters({{"gms_grid_columns", 0}, {"inlier_threshold_px", 0.}, {"sort_key", std::string()}}, options);
  EXPECT_EQ(options.motion_statistics.grid_columns, std::nullopt);
  EXPECT_EQ(options.robust.inlier_threshold_px, std::nullopt);
  EXPECT_EQ(options.robust.sort_key, std::nullopt);
  EXPECT_EQ(row("gms_grid_columns").accepted(), "a whole number between 2 and 100, or 0");
  EXPECT_EQ(row("gms_grid_columns").convert(1), std::nullopt);
  EXPECT_EQ(row("inlier_threshold_px").convert(std::nan("")), std::nullopt);
  options.motion_statistics.grid_columns = 0;  // the core has no word for "not set"
  EXPECT_THROW(options.validate(), std::invalid_argument);
}

TEST(Parameters, Types) {
  EXPECT_EQ(row("inlier_threshold_px").convert(2), ParameterValue(2.0)) << "a whole number is a number";
  EXPECT_EQ(row("features").convert(500.0), ParameterValue(500)) << "a number that is whole is a whole number";
  EXPECT_EQ(row("features").convert(500.5), std::nullopt);
  EXPECT_EQ(row("features").convert(1e300), std::nullopt);
  EXPECT_EQ(row("features").parse("1e3"), ParameterValue(1000));
  EXPECT_EQ(row("success_probability").parse("9.9e-1"), ParameterValue(0.99));
  EXPECT_EQ(row("success_probability").parse("nan"), std::nullopt);
  EXPECT_EQ(row("refine").parse("0"), ParameterValue(false));
  EXPECT_EQ(row("refine").parse("maybe"), std::nullopt);
  EXPECT_EQ(row("features").parse("500x"), std::nullopt);
}

TEST(Parameters, RefusesByName) {
  const auto complaint = [](const std::string& name, const ParameterValue& value) -> std::string {
    try {
      MatchFilterOptions options;
      setParameters({{name, value}}, options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint("gms_border", std::string("somewhere")),
            "gms_border is 'somewhere'; it must be one of 'opencv' 'original'");
  EXPECT_EQ(complaint("features", 0), "features is '0'; it must be a whole number between 1 and 100000");
  EXPECT_EQ(complaint("seed", true), "seed is 'true'; it must be a whole number between 0 and 2147483647");
  EXPECT_EQ(complaint("featuers", 100), "there is no parameter 'featuers'");
}

TEST(Parameters, AnyPyramidOfTheOpenCvExtractorWorksOnAnyImage) {
  FeatureExtractorOptions options;
  options.extractor = "opencv";
  for (const auto& [levels, factor] : {std::pair(11, 2.0), std::pair(16, 1.6), std::pair(16, 2.0), std::pair(8, 1.2)}) {
    options.pyramid_levels = levels;
    options.pyramid_scale = factor;
    const auto extractor = makeFeatureExtractor(options);
    for (const cv::Size& size : {cv::Size(640, 480), cv::Size(63, 700), cv::Size(97, 131), cv::Size(320, 240)}) {
      cv::Mat image(size, CV_8UC1);
      cv::randu(image, 0, 256);
      Features features;
      ASSERT_NO_THROW(extractor->extract(image, features)) << levels << " " << factor << " " << size;
      EXPECT_GT(features.size(), 0) << levels << " " << factor << " " << size;
    }
  }
}

TEST(Parameters, ThePapersFileIsThePapersPreset) {
  std::ifstream file(GMS_RANSAC_SOURCE_DIR "/cfg/paper.yaml");
  MatchFilterOptions options;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name, value;
    if (!(words >> name >> value)) continue;
    name.pop_back();  // the colon
    const std::optional<ParameterValue> parsed = row(name).parse(value);
    ASSERT_TRUE(parsed) << line;
    setParameters({{name, *parsed}}, options);
  }
  EXPECT_EQ(parametersOf(options), parametersOf(MatchFilterOptions::paper()));
}

}  // namespace
}  // namespace gms_ransac
