#include "robust/fast/motion_starts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gms_ransac {

namespace {

// Matches and steps for each start: with half the matches or half the steps more pairs end in a wrong valley, twice as
// many of either gain nothing (doc/estimator.md).
constexpr int kStartMatches = 256;
constexpr int kStartIterations = 4;
// Every match counts, but from twice the threshold on ever less: the start is far off.
constexpr Loss kStartLoss = {1e4f, 1 / 4.f};
// Directions closer than this are the same valley.
constexpr double kSameDirection = 0.99;

struct Start {
  TwoViewPose pose;
  float cost;
};

/// Optimises both the pose and, since the Sampson distance cannot tell t from -t, picks its sign by cheirality.
Start optimizeStart(const PoseModel& model, const PointColumnsView& points, TwoViewPose pose, int64_t& evaluations) {
  evaluations += static_cast<int64_t>(points.count) * model.refine(kStartLoss, kStartIterations, pose);
  const TwoViewPose opposite = {pose.R, -pose.t};
  constexpr float kNoBound = std::numeric_limits<float>::max();
  Score score, opposite_score;
  model.score(pose, kNoBound, score, evaluations);
  model.score(opposite, kNoBound, opposite_score, evaluations);
  if (opposite_score.cost < score.cost) return {opposite, opposite_score.cost};
  return {pose, score.cost};
}

/// Puts `start` into the list, best first, that holds at most one for a direction.
void insertStart(const Start& start, Start (&list)[kMaxMotionStarts], int& count) {
  for (int i = 0; i < count; ++i) {
    if (std::abs(list[i].pose.t.dot(start.pose.t)) < kSameDirection) continue;
    if (start.cost >= list[i].cost) return;
    for (int j = i; j + 1 < count; ++j) list[j] = list[j + 1];
    --count;
    break;
  }
  int place = count;
  while (place > 0 && start.cost < list[place - 1].cost) --place;
  if (place == kMaxMotionStarts) return;
  count = std::min(count + 1, kMaxMotionStarts);
  for (int j = count - 1; j > place; --j) list[j] = list[j - 1];
  list[place] = start;
}

}  // namespace

Eigen::Matrix3d fitDominantRotation(const PoseModel& model, const PointColumnsView& points,
                                    const Eigen::Matrix3d& start, int64_t& evaluations) {
  constexpr int kIterations = 4;
  Eigen::Matrix3d R = start;
  // Squared scales of the loss in squared thresholds: a hundred, twenty and ten pixels at a threshold of one.
  for (float softness : {1e4f, 400.f, 100.f}) {
    const Loss loss = {std::numeric_limits<float>::max(), 1 / softness};
    evaluations += static_cast<int64_t>(points.count) * model.refineRotation(loss, kIterations, R);
  }
  return R;
}

int findMotionStarts(const ResidualKernels& kernels, const PointColumnsView& points,
                     TwoViewPose (&starts)[kMaxMotionStarts], int64_t& evaluations) {
  PointColumnsView part = points;
  if (part.count > kStartMatches) part.size = part.count = kStartMatches;
  const PoseModel model(kernels, part);
  const Eigen::Matrix3d rotations[2] = {fitDominantRotation(model, part, Eigen::Matrix3d::Identity(), evaluations),
                                        Eigen::Matrix3d::Identity()};
  Start list[kMaxMotionStarts];
  int count = 0;
  for (const Eigen::Matrix3d& R : rotations) {
    // Half of the 26 directions to a cube's corners, edges and faces: the others are their opposites.
    for (int code = 14; code < 27; ++code) {
      const Eigen::Vector3d direction(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1);
      insertStart(optimizeStart(model, part, {R, direction.normalized()}, evaluations), list, count);
    }
  }
  for (int i = 0; i < count; ++i) starts[i] = list[i].pose;
  return count;
}

}  // namespace gms_ransac
