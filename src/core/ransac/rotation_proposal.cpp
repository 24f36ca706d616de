#include "ransac/rotation_proposal.h"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// Matches that judge a direction, and directions.
constexpr int kPart = 256;
constexpr int kDirections = 32;
constexpr int kCoarseIterations = 6;
constexpr int kFineIterations = 10;

Eigen::Vector3d planeNormal(const PointColumnsView& points, int column, const Eigen::Matrix3d& R) {
  const Eigen::Vector3d turned = R * Eigen::Vector3d(points.x1[column], points.y1[column], 1);
  return turned.cross(Eigen::Vector3d(points.x2[column], points.y2[column], 1));
}

Eigen::Vector3d directionOf(const PointColumnsView& points, int first, int second, const Eigen::Matrix3d& R) {
  return planeNormal(points, first, R).cross(planeNormal(points, second, R)).stableNormalized();
}

}  // namespace

PointColumnsView RotationProposal::widen(const PointColumnsView& points, const RotationPrior& prior) {
  const PointColumnsView part = firstColumns(points, kPart);
  widened_.copy(part, [](int) { return true; });
  // Near the optical axis a rotation moves points by its angle, on the normalised image plane.
  const auto moved = static_cast<float>(prior.covariance.diagonal().maxCoeff());
  std::transform(part.weight, part.weight + part.count, widened_.weight(),
                 [moved](float weight) { return weight / (1 + weight * std::max(0.f, moved)); });
  return widened_.view();
}

TwoViewPose RotationProposal::find(const ResidualKernels& kernels, const PointColumnsView& points,
                                   const RotationPrior& prior) {
  const PointColumnsView part = widen(points, prior);
  const PoseModel coarse(kernels, part, kParallaxPrior);
  TwoViewPose best = {prior.R.transpose(), Eigen::Vector3d::UnitZ()};
  float best_cost = std::numeric_limits<float>::infinity();
  // The order of the columns has nothing to do with the image's, so neighbours are as good as any two.
  for (int column = 0; column + 1 < std::min(part.count, 2 * kDirections); column += 2) {
    const Eigen::Vector3d t = directionOf(part, column, column + 1, best.R);
    if (!(t.squaredNorm() > 0.5)) continue;
    float cost;
    const TwoViewPose pose = coarse.withBetterSign({best.R, t}, cost);
    if (cost >= best_cost) continue;
    best = pose;
    best_cost = cost;
  }
  coarse.refine(kRobustLoss, kCoarseIterations, best);
  const PoseModel model(kernels, points, kParallaxPrior);
  model.refine(kRobustLoss, kFineIterations, best);
  return model.withBetterSign(best, best_cost);
}

}  // namespace gms_ransac
