#include "judgement/second_motion.h"

#include <algorithm>

#include "ransac/motion_starts.h"

namespace gms_ransac {

namespace {

constexpr double kMostOfSecond = 0.8, kMostOfSecondJoined = 0.6;
constexpr int kIterations = 10;

}  // namespace

double mostOfSecondMotion(double contradiction) { return contradiction > 1 ? kMostOfSecondJoined : kMostOfSecond; }

double SecondMotion::share(const PointColumnsView& points, const MatchNoise& noise, double least) {
  rest_.clear();
  for (int i = 0; i < points.count; ++i) {
    if (noise.probabilities()[static_cast<size_t>(i)] < 0.5f) rest_.push_back(i);
  }
  const int rest = static_cast<int>(rest_.size()), explained = points.count - rest;
  if (rest < least * explained) return 0;
  rest_points_.gather(points, rest_.data(), rest);
  findMotionStarts(kernels_, rest_points_.view(), motions_);
  int most = 0;
  for (TwoViewPose& motion : motions_) {
    const PoseModel model(kernels_, rest_points_.view());
    model.refine(kRobustLoss, kIterations, motion);
    model.residualsInFront(motion, residuals_);
    most = std::max(most, static_cast<int>(std::count_if(residuals_.begin(), residuals_.begin() + rest,
                                                         [](float residual) { return residual < 1; })));
  }
  return static_cast<double>(most) / explained;
}

}  // namespace gms_ransac
