#include "ransac/motion_starts.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// Steps for each start, and how many go on to the second round (doc/estimator.md).
constexpr int kStartIterations = 3;
constexpr int kSecondIterations = 4;
constexpr int kSecondRound = 8;
// Every match counts, but from twice the threshold on ever less: the start is far off.
constexpr Loss kStartLoss = {1e4f, 1 / 4.f};
// A dominant rotation this small is none: starts from both end in the same places (doc/estimator.md).
constexpr double kNoRotation = 2 * M_PI / 180;
// Cosine: directions closer than this (8 degrees) are the same local minimum.
constexpr double kSameDirection = 0.99;

struct Start {
  TwoViewPose pose;
  float cost;
};

Start optimizeStart(const PoseModel& model, int iterations, TwoViewPose pose) {
  model.refine(kStartLoss, iterations, pose);
  Start start;
  start.pose = model.withBetterSign(pose, start.cost);
  return start;
}

bool cheaper(const Start& a, const Start& b) { return a.cost < b.cost; }

/// True if one of the starts has about the direction of another.
bool hasDirection(const std::vector<TwoViewPose>& starts, const TwoViewPose& other) {
  return std::any_of(starts.begin(), starts.end(),
                     [&](const TwoViewPose& start) { return std::abs(start.t.dot(other.t)) > kSameDirection; });
}

}  // namespace

Eigen::Matrix3d fitDominantRotation(const PoseModel& model, const Eigen::Matrix3d& start) {
  constexpr int kIterations = 4;
  Eigen::Matrix3d R = start;
  // Squared scales of the loss in squared thresholds: a hundred, twenty and ten pixels at a threshold of one.
  for (float softness : {1e4f, 400.f, 100.f}) {
    const Loss loss = {std::numeric_limits<float>::max(), 1 / softness};
    model.refineRotation(loss, kIterations, R);
  }
  return R;
}

void findMotionStarts(const ResidualKernels& kernels, const PointColumnsView& points,
                      std::vector<TwoViewPose>& starts) {
  const PointColumnsView part = firstColumns(points, kRandomPart);
  const PoseModel model(kernels, part, kParallaxPrior);
  const Eigen::Matrix3d dominant = fitDominantRotation(model, Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d rotations[2] = {dominant, Eigen::Matrix3d::Identity()};
  const int rotation_count = Eigen::AngleAxisd(dominant).angle() < kNoRotation ? 1 : 2;
  Start all[2 * 13];
  int all_count = 0;
  for (int k = 0; k < rotation_count; ++k) {
    // Half of the 26 directions to a cube's corners, edges and faces: the others are their opposites.
    for (int code = 14; code < 27; ++code) {
      const int x = code % 3 - 1, y = code / 3 % 3 - 1, z = code / 9 - 1;
      const Eigen::Vector3d direction(x, y, z);
      all[all_count++] = optimizeStart(model, kStartIterations, {rotations[k], direction.normalized()});
    }
  }
  std::sort(all, all + all_count, cheaper);
  for (int i = 0; i < kSecondRound; ++i) all[i] = optimizeStart(model, kSecondIterations, all[i].pose);
  std::sort(all, all + kSecondRound, cheaper);
  starts.clear();
  for (int i = 0; i < kSecondRound && starts.size() < kMaxMotionStarts; ++i) {
    if (!hasDirection(starts, all[i].pose)) starts.push_back(all[i].pose);
  }
}

}  // namespace gms_ransac
