// Zhu's distance consistency on matches whose right and wrong ones are known.
#include "gms/distance_consistency.h"

#include <gtest/gtest.h>

#include <random>

namespace gms_ransac {
namespace {

/// 300 accepted matches over 400 x 400 pixels that zoom by `zoom` about the centre; every tenth has an error
/// of `error` pixels.
struct LabelledScene {
  Features reference, current;
  std::vector<Match> matches;
  MotionStatistics statistics;

  LabelledScene(float zoom, float error) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> coordinate(0.f, 400.f), noise(-0.5f, 0.5f);
    statistics.grid_columns = statistics.grid_rows = 5;
    for (int i = 0; i < 300; ++i) {
      const cv::Point2f p(coordinate(random), coordinate(random)), centre(200.f, 200.f);
      cv::Point2f q = centre + zoom * (p - centre) + cv::Point2f(10.f + noise(random), noise(random));
      if (wrong(i)) q.x += error;
      reference.keypoints.emplace_back(p, 31.f);
      current.keypoints.emplace_back(q, 31.f);
      matches.push_back({i, i, 0, 257});
      statistics.cell.push_back(static_cast<int>(p.y / 80) * 5 + static_cast<int>(p.x / 80));
    }
    statistics.accepted.assign(300, 1);
    statistics.score.assign(300, 7);
    statistics.relative_score.assign(300, 2.f);
    statistics.accepted_count = 300;
  }
  static bool wrong(int i) { return i % 10 == 0; }

  void apply(DistanceReading reading) { rejectInconsistent(reading, 3, reference, current, matches, statistics); }
  int kept(bool of_wrong) const {
    int count = 0;
    for (int i = 0; i < 300; ++i) count += wrong(i) == of_wrong && statistics.accepted[i];
    return count;
  }
};

TEST(DistanceConsistency, DisplacementsMustAgreeWithTheNeighbours) {
  LabelledScene scene(1.f, 30.f);
  scene.apply(DistanceReading::kDisplacement);
  EXPECT_EQ(scene.kept(false), 270);
  EXPECT_EQ(scene.kept(true), 0);
  EXPECT_EQ(scene.statistics.accepted_count, 270);
  EXPECT_EQ(scene.statistics.score[0], 0);
  EXPECT_EQ(scene.statistics.relative_score[0], 0.f);
  EXPECT_EQ(scene.statistics.score[1], 7);
}

TEST(DistanceConsistency, ThreePixelsAreAlwaysTolerated) {
  LabelledScene scene(1.f, 1.5f);
  scene.apply(DistanceReading::kDisplacement);
  EXPECT_EQ(scene.statistics.accepted_count, 300);
}

TEST(DistanceConsistency, PairwiseDistancesMayScaleTogether) {
  LabelledScene scene(1.4f, 200.f);
  scene.apply(DistanceReading::kPairwise);
  EXPECT_GT(scene.kept(false), 250);
  EXPECT_LT(scene.kept(true), 10);
}

TEST(DistanceConsistency, NoneOneAndCoincidingMatches) {
  for (const DistanceReading reading : {DistanceReading::kDisplacement, DistanceReading::kPairwise}) {
    LabelledScene scene(1.f, 0.f);
    scene.statistics.accepted.assign(300, 0);
    scene.apply(reading);
    EXPECT_EQ(scene.kept(false), 0);
    scene.statistics.accepted[5] = 1;
    scene.apply(reading);
    EXPECT_EQ(scene.statistics.accepted[5], 1);  // no neighbour to disagree with
  }
  LabelledScene scene(1.f, 0.f);
  for (auto& keypoint : scene.reference.keypoints) keypoint.pt = {50.f, 50.f};
  scene.apply(DistanceReading::kPairwise);  // no distance to compare: must not divide by it
  EXPECT_EQ(scene.statistics.accepted_count, 0);
}

}  // namespace
}  // namespace gms_ransac
