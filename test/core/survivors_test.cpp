// Survivors, from the filter to the estimator: one match a point, and their spread over the image, independent of the
// grid that voted.
#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gms_ransac/match_filter.h"
#include "tracks/track_table.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

const cv::Size kImage(640, 480);

/// Two frames whose keypoints are drawn, keypoint k of one being keypoint k of the other.
struct DrawnPair {
  Frame reference, current;
  std::vector<std::vector<uint8_t>> descriptors_reference, descriptors_current;

  void add(const cv::Point2f& reference_point, const std::vector<uint8_t>& descriptor) {
    reference.features.keypoints.emplace_back(reference_point, 31.f, 0.f, 1.f, 0);
    descriptors_reference.push_back(descriptor);
  }
  void finish() {
    write(descriptors_reference, reference.features);
    write(descriptors_current, current.features);
  }

 private:
  static void write(const std::vector<std::vector<uint8_t>>& rows, Features& features) {
    features.image_size = kImage;
    features.descriptors.resize(static_cast<int>(rows.size()));
    for (size_t i = 0; i < rows.size(); ++i) {
      std::copy(rows[i].begin(), rows[i].end(), features.descriptors.row(static_cast<int>(i)));
    }
    features.descriptors.pack();
  }
};

/// Points 3 to 9 m away in the `share` of the image about its middle, seen exactly from two places, each with a
/// descriptor of its own.
DrawnPair drawPair(int count, double share, uint64_t seed) {
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
  DrawnPair pair;
  Random random(seed);
  for (size_t k = 0; k < static_cast<size_t>(count); ++k) {
    std::vector<uint8_t> descriptor(kDescriptorBytes);
    for (uint8_t& byte : descriptor) byte = static_cast<uint8_t>(random.below(256));
    pair.add({points.x_reference[k], points.y_reference[k]}, descriptor);
    pair.current.features.keypoints.emplace_back(points.x_current[k], points.y_current[k], 31.f, 0.f, 1.f, 0);
    pair.descriptors_current.push_back(descriptor);
  }
  return pair;
}

class Grid : public testing::TestWithParam<int> {};

TEST_P(Grid, DoesNotDecideWhetherTheMatchesAreSpread) {
  MatchFilterOptions options;
  MotionStatisticsOptions& gms = options.motion_statistics;
  if (GetParam() > 0) gms.grid_columns = gms.grid_rows = GetParam();
  for (const int count : {40, 80}) {
    for (uint64_t seed = 0; seed < 20; ++seed) {
      DrawnPair pair = drawPair(count, 0.5, seed);
      pair.finish();
      MatchFilter filter(options);
      filter.setCamera(sceneCamera());
      MatchResult result;
      filter.filter(pair.reference, pair.current, result);
      EXPECT_EQ(toString(result.status), "OK") << count << " matches, seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(CellsToASide, Grid, testing::Values(0, 2, 3, 4, 5, 10, 20, 40));

class OneToOne : public testing::TestWithParam<std::string> {};

constexpr int kPoints = 400, kDoubles = 150;

/// A pair in which the first points have a double in the reference, next to them and equal except for a few bits.
DrawnPair drawPairWithDoubles() {
  DrawnPair pair = drawPair(kPoints, 1, 3);
  for (int k = 0; k < kDoubles; ++k) {
    std::vector<uint8_t> descriptor = pair.descriptors_reference[static_cast<size_t>(k)];
    descriptor[0] ^= 0x1f;
    const cv::Point2f beside(0.3f, 0.2f);
    pair.add(pair.reference.features.keypoints[static_cast<size_t>(k)].pt + beside, descriptor);
  }
  pair.finish();
  return pair;
}

MatchResult filtered(const std::string& method, bool one_to_one) {
  MatchFilterOptions options;
  options.method = method;
  options.one_to_one = one_to_one;
  MatchFilter filter(options);
  filter.setCamera(sceneCamera());
  const DrawnPair pair = drawPairWithDoubles();
  MatchResult result;
  filter.filter(pair.reference, pair.current, result);
  return result;
}

int currentPoints(const MatchResult& result) {
  std::set<int> points;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (result.stage[i] == MatchStage::kInlier) points.insert(result.matches[i].current);
  }
  return static_cast<int>(points.size());
}

TEST_P(OneToOne, KeepsTheBetterMatchOfEachPoint) {
  const MatchResult result = filtered(GetParam(), true);
  ASSERT_EQ(result.matches.size(), static_cast<size_t>(GetParam() == "lan" ? kPoints : kPoints + kDoubles));
  EXPECT_GT(result.inliers, kPoints / 3);
  EXPECT_EQ(result.inliers, currentPoints(result));
  EXPECT_LE(result.inliers, result.matches_gms);
  EXPECT_LE(result.matches_gms, kPoints);
  TrackTable tracks;
  tracks.link(result);
  int doubles = 0, untracked = 0;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (result.stage[i] != MatchStage::kInlier) continue;
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

}  // namespace
}  // namespace gms_ransac
