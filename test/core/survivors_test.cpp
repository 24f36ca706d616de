// Survivors, from the filter to the estimator: one match a point, and their spread over the image, independent of the
// grid that voted.
#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "gms_ransac/match_filter.h"
#include "stages.h"
#include "survivors.h"
#include "tracks/track_table.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

/// Two frames with drawn keypoints; those of one index are of one point.
struct DrawnPair {
  Frame reference, current;

  /// Points 3 to 9 m away in the `share` of the image about its middle, seen exactly from two places, each with a
  /// descriptor of its own. The first `doubles` have a double in the reference, next to them and equal except for a few
  /// bits.
  DrawnPair(int count, double share, uint64_t seed, int doubles = 0) {
    TwoViewSceneOptions options;
    options.seed = seed;
    options.matches = count;
    options.outlier_ratio = 0;
    options.noise_px = 0;
    options.image_share = share;
    options.nearest = 3;
    options.farthest = 9;
    options.rotation = 0.05 * Eigen::Vector3d(0.2, 1, -0.1).normalized();
    options.translation = {-0.35, 0.1, -0.15};
    const PointPairs points = makeTwoViewScene(options).pairs;
    cv::Mat rows(count + doubles, kDescriptorBytes, CV_8U);
    cv::RNG(seed + 1).fill(rows, cv::RNG::UNIFORM, 0, 256);
    for (int k = 0; k < count; ++k) {
      add(reference, {points.x_reference[k], points.y_reference[k]});
      add(current, {points.x_current[k], points.y_current[k]});
    }
    for (int k = 0; k < doubles; ++k) {
      add(reference, {points.x_reference[k] + 0.3f, points.y_reference[k] + 0.2f});
      rows.row(k).copyTo(rows.row(count + k));
      rows.at<uint8_t>(count + k, 0) ^= 0x1f;
    }
    reference.features.descriptors.assign(rows);
    current.features.descriptors.assign(rows.rowRange(0, count));
    reference.features.image_size = current.features.image_size = {640, 480};
  }

 private:
  static void add(Frame& frame, const cv::Point2f& point) {
    frame.features.keypoints.emplace_back(point, 31.f, 0.f, 1.f, 0);
  }
};

MatchResult filtered(const DrawnPair& pair, const MatchFilterOptions& options) {
  MatchFilter filter(options);
  filter.setCamera(sceneCamera());
  MatchResult result;
  filter.filter(pair.reference, pair.current, result);
  return result;
}

TEST(Grid, DoesNotDecideWhetherTheMatchesAreSpread) {
  MatchFilterOptions options;
  MotionStatisticsOptions& gms = options.motion_statistics;
  for (const int count : {40, 80}) {
    for (uint64_t seed = 0; seed < 20; ++seed) {
      const DrawnPair pair(count, 0.5, seed);
      for (const int side : {0, 2, 3, 4, 5, 10, 20, 40}) {
        if (side > 0) gms.grid_columns = gms.grid_rows = side;
        if (side == 0) gms = {};
        EXPECT_EQ(filtered(pair, options).status, Status::kOk)
            << count << " matches, seed " << seed << ", side " << side;
      }
    }
  }
}

class OneToOne : public testing::TestWithParam<std::string> {};

constexpr int kPoints = 400, kDoubles = 150;

MatchResult filtered(const std::string& method, bool one_to_one) {
  MatchFilterOptions options;
  options.method = method;
  options.one_to_one = one_to_one;
  return filtered(DrawnPair(kPoints, 1, 3, kDoubles), options);
}

int currentPoints(const MatchResult& result) {
  std::set<int> points;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (result.isInlier(i)) points.insert(result.matches[i].current);
  }
  return static_cast<int>(points.size());
}

TEST_P(OneToOne, KeepsTheBetterMatchOfEachPoint) {
  const MatchResult result = filtered(GetParam(), true);
  ASSERT_EQ(result.raw.size(), static_cast<size_t>(GetParam() == "lan" ? kPoints : kPoints + kDoubles));
  EXPECT_GT(result.inliers, kPoints / 3);
  EXPECT_EQ(result.inliers, currentPoints(result));
  EXPECT_LE(result.inliers, result.size());
  EXPECT_LE(result.size(), kPoints);
  TrackTable tracks;
  tracks.link(result);
  int doubles = 0, untracked = 0;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (!result.isInlier(i)) continue;
    doubles += result.matches[i].distance > 0;
    untracked += tracks.ids()[i] == 0 || tracks.lengths()[i] < 2;
  }
  EXPECT_EQ(untracked, 0);
  EXPECT_LE(doubles, result.inliers / 50);
}

TEST_P(OneToOne, LeavesAllAsThePapersDoWhenOff) {
  const MatchResult result = filtered(GetParam(), false);
  if (GetParam() == "lan") return;  // matches in both directions
  EXPECT_GT(result.inliers, currentPoints(result) + kDoubles / 2);
}

INSTANTIATE_TEST_SUITE_P(Methods, OneToOne, testing::Values("ransac", "gms", "lan", "cp_ransac", "lo_prosac"));

/// Stages of matches between these pixels, all accepted by the filter.
std::vector<MatchStage> stagesThrough(const Camera& camera,
                                      const std::vector<std::pair<cv::Point2f, cv::Point2f>>& pixels) {
  Features reference, current;
  MatchResult result;
  for (const auto& [from, to] : pixels) {
    const auto index = static_cast<int>(result.raw.size());
    reference.keypoints.emplace_back(from, 31.f);
    current.keypoints.emplace_back(to, 31.f);
    result.raw.push_back({index, index, 10, 60});
  }
  reference.image_size = current.image_size = camera.imageSize();
  MotionStatistics statistics;
  statistics.accepted.assign(pixels.size(), 1);
  statistics.score.assign(pixels.size(), 1);
  statistics.relative_score.assign(pixels.size(), 1.f);
  SurvivorSelector(false, false).select(reference, current, statistics, camera, result);
  return stagesOf(result);
}

TEST(SurvivorSelector, LeavesOutMatchesWhoseRayTheCalibrationDoesNotSay) {
  const Camera folding({250, 250, 320, 240, "plumb_bob", {-0.4, 0, 0, 0, 0}}, {640, 480});  // grows up to 152 px
  const auto right = [](float px) { return cv::Point2f(320 + px, 240); };
  const auto above = [](float px) { return cv::Point2f(320, 240 - px); };
  EXPECT_EQ(stagesThrough(folding, {{right(0), above(149)},
                                    {right(100), above(0)},
                                    {right(150), above(0)},
                                    {right(155), above(0)},
                                    {right(300), above(0)},
                                    {right(0), above(160)}}),
            (std::vector<MatchStage>{MatchStage::kGms, MatchStage::kGms, MatchStage::kGms, MatchStage::kRaw,
                                     MatchStage::kRaw, MatchStage::kRaw}));
}

TEST(SurvivorSelector, LeavesOutThePointInACornerThatAloneHasNoRay) {
  // Grows up to 399.5 px from the centre: the pixel (0, 0) is 400 px from it, and not among those that are counted.
  const Camera lens({600, 600, 320, 240, "plumb_bob", {-0.33417, 0, 0, 0, 0}}, {640, 480});
  ASSERT_EQ(lens.pixelsWithoutInverse(), 0);
  EXPECT_EQ(stagesThrough(lens, {{{0, 0}, {320, 240}}, {{1, 1}, {320, 240}}}),
            (std::vector<MatchStage>{MatchStage::kRaw, MatchStage::kGms}));
}

}  // namespace
}  // namespace gms_ransac
