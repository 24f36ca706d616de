// The list of reconfigurable parameters says the same as the core: defaults, and the words a choice knows. Whatever it
// offers works, or is refused with a sentence.
#include "parameters.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <fstream>
#include <functional>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "gms_ransac/track_selector.h"
#include "match_filter_config.h"

namespace gms_ransac {
namespace {

/// The words that cfg/MatchFilter.cfg offers for a parameter: its menu is a Python literal, read as a whole, unlike
/// parameters.cpp, which searches it.
std::set<std::string> offered(const std::string& parameter) {
  std::set<std::string> words;
  for (const auto& description : MatchFilterConfig::__getParamDescriptions__()) {
    if (description->name != parameter || description->edit_method.empty()) continue;
    std::string menu = description->edit_method;
    std::replace(menu.begin(), menu.end(), '\'', '"');
    const nlohmann::json constants = nlohmann::json::parse(menu).at("enum");
    for (const nlohmann::json& constant : constants) words.insert(constant.at("value"));
  }
  return words;
}

TEST(Parameters, OffersEveryMethodAndNoOther) {
  std::set<std::string> known;
  for (const MethodEntry& method : methods()) known.insert(method.name);
  EXPECT_EQ(offered("method"), known) << "cfg/MatchFilter.cfg and the table of methods differ";
}

TEST(Parameters, OffersOnlyWordsTheCoreTakes) {
  for (const char* parameter : {"extractor", "model", "gms_border", "method", "quality"}) {
    ASSERT_FALSE(offered(parameter).empty()) << parameter;
    for (const std::string& word : offered(parameter)) {
      MatchFilterConfig config = MatchFilterConfig::__getDefault__();
      if (std::string(parameter) == "extractor") config.extractor = word;
      if (std::string(parameter) == "model") config.model = word;
      if (std::string(parameter) == "gms_border") config.gms_border = word;
      if (std::string(parameter) == "method") config.method = word;
      if (std::string(parameter) == "quality") config.quality = word;
      EXPECT_NO_THROW(MatchFilter{coreOptions(config)}) << parameter << " " << word;
    }
  }
}

TEST(Parameters, DefaultsAreTheCores) {
  const MatchFilterOptions node = coreOptions(MatchFilterConfig::__getDefault__()), core;
  EXPECT_EQ(node.method, core.method);
  EXPECT_EQ(node.extractor.extractor, core.extractor.extractor);
  EXPECT_EQ(node.extractor.features, core.extractor.features);
  EXPECT_EQ(node.extractor.levels, core.extractor.levels);
  EXPECT_EQ(node.extractor.scale_factor, core.extractor.scale_factor);
  EXPECT_EQ(node.extractor.fast_threshold, core.extractor.fast_threshold);
  EXPECT_EQ(node.motion_statistics.grid_columns, core.motion_statistics.grid_columns);
  EXPECT_EQ(node.motion_statistics.grid_rows, core.motion_statistics.grid_rows);
  EXPECT_EQ(node.motion_statistics.threshold_factor, core.motion_statistics.threshold_factor);
  EXPECT_EQ(node.motion_statistics.rotation, core.motion_statistics.rotation);
  EXPECT_EQ(node.motion_statistics.scale, core.motion_statistics.scale);
  EXPECT_EQ(node.motion_statistics.border, core.motion_statistics.border);
  EXPECT_EQ(node.motion_statistics.acceptance, core.motion_statistics.acceptance);
  EXPECT_EQ(node.distance_reading, core.distance_reading);
  EXPECT_EQ(node.one_to_one, core.one_to_one);
  EXPECT_EQ(node.lan_mutual, core.lan_mutual);
  EXPECT_EQ(node.second_alpha, core.second_alpha);
  EXPECT_EQ(node.robust.model, core.robust.model);
  EXPECT_EQ(node.robust.threshold_px, core.robust.threshold_px);
  EXPECT_EQ(node.robust.confidence, core.robust.confidence);
  EXPECT_EQ(node.robust.max_iterations, core.robust.max_iterations);
  EXPECT_EQ(node.robust.seed, core.robust.seed);
  EXPECT_EQ(node.robust.ratio, core.robust.ratio);
  EXPECT_EQ(node.robust.geometric_groups, core.robust.geometric_groups);
  EXPECT_EQ(node.robust.tdd_d, core.robust.tdd_d);
  EXPECT_EQ(node.robust.subset_count, core.robust.subset_count);
  EXPECT_EQ(node.robust.subset_fraction, core.robust.subset_fraction);
  EXPECT_EQ(node.robust.split, core.robust.split);
  EXPECT_EQ(node.robust.target_ratio, core.robust.target_ratio);
  EXPECT_EQ(node.robust.quality, core.robust.quality);
  EXPECT_EQ(node.robust.judge, core.robust.judge);
  EXPECT_EQ(node.robust.refine, core.robust.refine);
  EXPECT_EQ(MatchFilterConfig::__getDefault__().feature_limit, TrackSelectorOptions().limit);
  EXPECT_EQ(MatchFilterConfig::__getDefault__().feature_distance, TrackSelectorOptions().distance);
}

/// One thing to be asked for: a parameter, as text for messages, and how it is set.
struct Setting {
  std::string text;
  std::function<void(MatchFilterConfig&)> apply;
};

template <typename Value>
Setting setting(const MatchFilterConfig::AbstractParamDescriptionConstPtr& description, Value value) {
  std::ostringstream text;
  text << description->name << " " << value;
  return {text.str(), [description, value](MatchFilterConfig& config) {
            const auto& of_type = static_cast<const MatchFilterConfig::ParamDescription<Value>&>(*description);
            config.*of_type.field = value;
          }};
}

/// The ends of every range and every word, parameter by parameter.
std::vector<std::vector<Setting>> corners() {
  std::vector<std::vector<Setting>> all;
  const MatchFilterConfig &low = MatchFilterConfig::__getMin__(), &high = MatchFilterConfig::__getMax__();
  for (const auto& description : MatchFilterConfig::__getParamDescriptions__()) {
    all.emplace_back();
    if (description->type == "bool") all.back() = {setting(description, false), setting(description, true)};
    if (description->type == "str") {
      for (const std::string& word : offered(description->name)) all.back().push_back(setting(description, word));
    }
    for (const MatchFilterConfig* end : {&low, &high}) {
      boost::any value;
      description->getValue(*end, value);
      if (description->type == "int") all.back().push_back(setting(description, boost::any_cast<int>(value)));
      if (description->type == "double") all.back().push_back(setting(description, boost::any_cast<double>(value)));
    }
  }
  return all;
}

/// Two views of drawn rectangles at two depths.
std::pair<cv::Mat, cv::Mat> drawnPair() {
  const cv::Size size(320, 240);
  cv::Mat first(size, CV_8UC1, cv::Scalar(90)), second = first.clone();
  cv::RNG random(5);
  for (int i = 0; i < 500; ++i) {
    const cv::Point corner(random.uniform(-20, size.width), random.uniform(-20, size.height));
    const cv::Rect box(corner, cv::Size(random.uniform(4, 25), random.uniform(4, 25)));
    const cv::Scalar grey(random.uniform(0, 255));
    cv::rectangle(first, box, grey, cv::FILLED);
    cv::rectangle(second, box + cv::Point(i < 250 ? 2 : 6, 0), grey, cv::FILLED);
  }
  return {first, second};
}

/// Answers the pair under these options, or refuses them; whatever else it does is a failure.
void expectAnAnswer(const MatchFilterConfig& config, const std::pair<cv::Mat, cv::Mat>& images) {
  MatchFilterOptions options;
  try {
    options = coreOptions(config);
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(" must "), std::string::npos) << error.what();
    return;
  }
  try {
    MatchFilter filter(options);
    filter.setCamera(Camera({260, 260, 160, 120, "", {}}, images.first.size()));
    filter.process(images.first);
    const MatchResult& result = filter.process(images.second);
    const bool answered = result.status == Status::kOk || result.status == Status::kLowParallax;
    if (answered) {
      EXPECT_GE(result.inliers, kMinimumMatches) << toString(result.status);
    }
    EXPECT_EQ(answered, result.robust.pose_found) << toString(result.status);
  } catch (const std::exception& error) {
    ADD_FAILURE() << error.what();
  }
}

TEST(Parameters, EveryCornerOfEveryRangeIsAnsweredOrRefused) {
  const auto images = drawnPair();
  for (const MethodEntry& method : methods()) {
    for (const auto& parameter : corners()) {
      for (const Setting& corner : parameter) {
        SCOPED_TRACE(method.name + std::string(", ") + corner.text);
        MatchFilterConfig config = MatchFilterConfig::__getDefault__();
        config.features = 500;
        config.method = method.name;
        corner.apply(config);
        expectAnAnswer(config, images);
      }
    }
  }
}

TEST(Parameters, CornersOfSeveralRangesAtOnceAreAnsweredOrRefused) {
  constexpr int kCombinations = 400, kParameters = 4;
  constexpr int kFewIterations = 500;  // none of this is about patience
  const auto images = drawnPair();
  const auto all = corners();
  std::mt19937 random(3);
  for (int i = 0; i < kCombinations; ++i) {
    MatchFilterConfig config = MatchFilterConfig::__getDefault__();
    config.features = 500;
    config.method = methods()[random() % methods().size()].name;
    std::string text = config.method;
    for (int k = 0; k < kParameters; ++k) {
      const auto& parameter = all[random() % all.size()];
      const Setting& corner = parameter[random() % parameter.size()];
      corner.apply(config);
      text += ", " + corner.text;
    }
    config.max_iterations = std::min(config.max_iterations, kFewIterations);
    SCOPED_TRACE(text);
    expectAnAnswer(config, images);
  }
}

TEST(Parameters, AnyPyramidOfTheOpenCvExtractorWorksOnAnyImage) {
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  config.extractor = "opencv";
  for (const auto& [levels, factor] : {std::pair(11, 2.0), std::pair(16, 1.6), std::pair(16, 2.0), std::pair(8, 1.2)}) {
    config.pyramid_levels = levels;
    config.pyramid_scale = factor;
    const auto extractor = makeFeatureExtractor(coreOptions(config).extractor);
    const cv::Mat image = drawnPair().first;
    for (const cv::Size& size : {cv::Size(640, 480), cv::Size(63, 700), cv::Size(97, 131), cv::Size(320, 240)}) {
      cv::Mat resized;
      cv::resize(image, resized, size);
      Features features;
      ASSERT_NO_THROW(extractor->extract(resized, features)) << levels << " " << factor << " " << size;
      EXPECT_GT(features.size(), 0) << levels << " " << factor << " " << size;
    }
  }
}

TEST(Parameters, ThePapersFileIsThePapersPreset) {
  std::ifstream file(GMS_RANSAC_SOURCE_DIR "/cfg/paper.yaml");
  dynamic_reconfigure::Config message;
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  config.__toMessage__(message);
  int set = 0;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name, value;
    if (!(words >> name >> value)) continue;
    name.pop_back();  // the colon
    for (auto& each : message.strs) set += each.name == name ? (each.value = value, 1) : 0;
    for (auto& each : message.bools) set += each.name == name ? (each.value = value == "true", 1) : 0;
    for (auto& each : message.doubles) set += each.name == name ? (each.value = std::stod(value), 1) : 0;
  }
  EXPECT_EQ(set, 7) << "every line of the file is a parameter";
  ASSERT_TRUE(config.__fromMessage__(message));
  const MatchFilterOptions file_options = coreOptions(config), paper = MatchFilterOptions::paper();
  EXPECT_EQ(file_options.method, paper.method);
  EXPECT_EQ(file_options.extractor.extractor, paper.extractor.extractor);
  EXPECT_EQ(file_options.one_to_one, paper.one_to_one);
  EXPECT_EQ(file_options.robust.quality, paper.robust.quality);
  EXPECT_EQ(file_options.robust.ratio, paper.robust.ratio);
  EXPECT_EQ(file_options.robust.refine, paper.robust.refine);
  EXPECT_EQ(file_options.robust.judge, paper.robust.judge);
  EXPECT_EQ(file_options.robust.threshold_px, paper.robust.threshold_px);
}

TEST(Parameters, RefusesAnUnknownWordByName) {
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  config.gms_border = "somewhere";
  try {
    coreOptions(config);
    FAIL() << "accepted an unknown border rule";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("gms_border is 'somewhere'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace gms_ransac
