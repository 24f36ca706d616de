// The list of reconfigurable parameters says the same as the core: defaults, and the words a choice knows.
#include "parameters.h"

#include <gtest/gtest.h>

#include <set>

#include "gms_ransac/track_selector.h"

namespace gms_ransac {
namespace {

/// The words that cfg/MatchFilter.cfg offers for a parameter.
std::set<std::string> offered(const std::string& parameter) {
  std::set<std::string> words;
  for (const auto& description : MatchFilterConfig::__getParamDescriptions__()) {
    if (description->name != parameter) continue;
    const std::string key = "'value': '";
    for (size_t at = description->edit_method.find(key); at != std::string::npos;
         at = description->edit_method.find(key, at)) {
      at += key.size();
      words.insert(description->edit_method.substr(at, description->edit_method.find('\'', at) - at));
    }
  }
  return words;
}

TEST(Parameters, OffersEveryMethodAndNoOther) {
  std::set<std::string> known;
  for (const Method& method : methods()) known.insert(method.name);
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
  EXPECT_EQ(node.robust.refine, core.robust.refine);
  EXPECT_EQ(MatchFilterConfig::__getDefault__().feature_limit, TrackSelectorOptions().limit);
  EXPECT_EQ(MatchFilterConfig::__getDefault__().feature_distance, TrackSelectorOptions().distance);
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
