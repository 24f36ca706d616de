// The table of parameters binds each name to an option of its own, with the core's default and the words the core
// knows. All values that it offers work, or are refused with a sentence.
#include "parameters.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "methods/method.h"
#include "node/match_filter_config.h"
#include "parameter.h"
#include "parameter_binding.h"
#include "tracks/track_selector.h"

namespace gms_ransac {
namespace {

const Parameter& row(const std::string& name) { return findParameter(coreParameters(), name); }

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

TEST(Parameters, DefaultsAreTheCoresAndTheReconfigureFiles) {
  const ParameterValues core = parametersOf(MatchFilterOptions());
  const ParameterValues node = parametersOf(coreOptions({}, MatchFilterConfig::__getDefault__()));
  for (const Parameter& parameter : coreParameters()) {
    EXPECT_EQ(core.at(parameter.name), parameter.default_value) << parameter.name;
    EXPECT_EQ(node.at(parameter.name), parameter.default_value) << parameter.name;
  }
  EXPECT_EQ(MatchFilterConfig::__getDefault__().feature_limit, TrackSelectorOptions().limit);
  EXPECT_EQ(MatchFilterConfig::__getDefault__().feature_distance, TrackSelectorOptions().distance);
}

TEST(Parameters, TheWindowIsForRobotsAndTheRestIsSetAtStart) {
  EXPECT_LE(MatchFilterConfig::__getParamDescriptions__().size(), 30u);
  const MatchFilterOptions options = coreOptions({{"seed", 7}, {"features", 300}}, MatchFilterConfig::__getDefault__());
  EXPECT_EQ(options.robust.seed, 7u);
  EXPECT_EQ(options.extractor.features, 2000) << "dynamic_reconfigure read it from the server";
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
  EXPECT_FALSE(row("gms_grid_columns").accepts(1));
  EXPECT_FALSE(row("inlier_threshold_px").accepts(std::nan("")));
  options.motion_statistics.grid_columns = 0;  // the core has no word for "not set"
  EXPECT_THROW(options.validate(), std::invalid_argument);
}

TEST(Parameters, Types) {
  EXPECT_EQ(row("inlier_threshold_px").convert(2), ParameterValue(2.0)) << "a whole number is a number";
  EXPECT_EQ(row("features").convert(2.0), std::nullopt);
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
