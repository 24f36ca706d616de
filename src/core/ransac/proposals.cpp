#include "ransac/proposals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// Steps for each start, and how many go on to the second round (doc/measured/constants.md).
constexpr int kStartIterations = 3;
constexpr int kSecondIterations = 4;
constexpr int kSecondRound = 8;
// Every match counts, but from twice the threshold on ever less: the start is far off.
constexpr Loss kStartLoss = {1e4f, 1 / 4.f};
// A dominant rotation this small is none: starts from both end in the same places (doc/measured/constants.md).
constexpr double kNoRotation = 2 * M_PI / 180;
// Cosine: directions closer than this (8 degrees) are the same local minimum.
constexpr double kSameDirection = 0.99;

struct Start {
  TwoViewPose pose;
  float cost;
};

/// The prior of the parallax ranks starts; their steps do without (doc/measured/constants.md).
Start optimizeStart(const PoseModel& plain, const PoseModel& model, int iterations, TwoViewPose pose) {
  plain.refine(kStartLoss, iterations, pose);
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
  const PointColumnsView part = firstSlots(points, kRandomPart);
  const PoseModel plain(kernels, part), model(kernels, part, kParallaxPrior);
  const Eigen::Matrix3d dominant = fitDominantRotation(plain, Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d rotations[2] = {dominant, Eigen::Matrix3d::Identity()};
  const int rotation_count = Eigen::AngleAxisd(dominant).angle() < kNoRotation ? 1 : 2;
  Start all[2 * 13];
  int all_count = 0;
  for (int k = 0; k < rotation_count; ++k) {
    // Half of the 26 directions to a cube's corners, edges and faces: the others are their opposites.
    for (int code = 14; code < 27; ++code) {
      const int x = code % 3 - 1, y = code / 3 % 3 - 1, z = code / 9 - 1;
      const Eigen::Vector3d direction(x, y, z);
      all[all_count++] = optimizeStart(plain, model, kStartIterations, {rotations[k], direction.normalized()});
    }
  }
  std::sort(all, all + all_count, cheaper);
  for (int i = 0; i < kSecondRound; ++i) all[i] = optimizeStart(plain, model, kSecondIterations, all[i].pose);
  std::sort(all, all + kSecondRound, cheaper);
  starts.clear();
  for (int i = 0; i < kSecondRound && starts.size() < kMaxMotionStarts; ++i) {
    if (!hasDirection(starts, all[i].pose)) starts.push_back(all[i].pose);
  }
}

namespace {

constexpr int kDirections = 32;
constexpr int kCoarseIterations = 6;
constexpr int kFineIterations = 10;

Eigen::Vector3d planeNormal(const PointColumnsView& points, int slot, const Eigen::Matrix3d& R) {
  const Eigen::Vector3d turned = R * Eigen::Vector3d(points.x1[slot], points.y1[slot], 1);
  return turned.cross(Eigen::Vector3d(points.x2[slot], points.y2[slot], 1));
}

Eigen::Vector3d directionOf(const PointColumnsView& points, int first, int second, const Eigen::Matrix3d& R) {
  return planeNormal(points, first, R).cross(planeNormal(points, second, R)).stableNormalized();
}

/// The first slots, each with the threshold that the prior's noise leaves it.
PointColumnsView widen(const PointColumnsView& points, const RotationPrior& prior, PointColumns& widened) {
  const PointColumnsView part = firstSlots(points, kRandomPart);
  widened.copy(part, [](int) { return true; });
  // Near the optical axis a rotation moves points by its angle, on the normalised image plane.
  const auto moved = static_cast<float>(prior.covariance.diagonal().maxCoeff());
  std::transform(part.weight, part.weight + part.count, widened.weight(),
                 [moved](float weight) { return weight / (1 + weight * std::max(0.f, moved)); });
  return widened.view();
}

}  // namespace

TwoViewPose proposeFromRotation(const ResidualKernels& kernels, const PointColumnsView& points,
                                const RotationPrior& prior, PointColumns& storage) {
  const PointColumnsView part = widen(points, prior, storage);
  const PoseModel coarse(kernels, part, kParallaxPrior);
  TwoViewPose best = {prior.R.transpose(), Eigen::Vector3d::UnitZ()};
  float best_cost = std::numeric_limits<float>::infinity();
  // Slots are pseudo-random, so neighbours are as good as any two.
  for (int slot = 0; slot + 1 < std::min(part.count, 2 * kDirections); slot += 2) {
    const Eigen::Vector3d t = directionOf(part, slot, slot + 1, best.R);
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

namespace {

constexpr int kPlaneMatches = 128;
constexpr int kFewestMatches = 16;
constexpr int kFitIterations = 5;
constexpr double kTypicalDeviations = 3;                          ///< median deviations, in the first fit
constexpr double kWidening[kFitIterations] = {0, 100, 10, 1, 1};  ///< of that, so that a first fit may be rough
// A match lies on the plane within so many variances of the residuals, and no further than two thresholds.
constexpr double kNearVariances = 16, kFarthestNear = 4;
constexpr double kMedianOfSquare = 0.455;  ///< of a standard normal variable's
constexpr double kLeastShare = 0.6;        ///< of the matches, for the plane to be the scene
constexpr double kHopelessShare = 0.3;     ///< after the first fit to all
constexpr double kLeastSpread = 1e-8;      ///< of the squared singular values; below it the homography is a rotation

/// Equation of a match for the plane's normal: q x (R + t n^T) p = 0 is rotated + shift (n . p) = 0, linear in n.
struct PlaneEquation {
  Eigen::Vector3d p, rotated, shift;
  double weight, inverse_depth;

  PlaneEquation() = default;
  PlaneEquation(const PointColumnsView& points, int slot, const TwoViewPose& pose)
      : p(points.x1[slot], points.y1[slot], 1), weight(points.weight[slot]) {
    const Eigen::Vector3d q(points.x2[slot], points.y2[slot], 1);
    rotated = q.cross(pose.R * p);
    shift = q.cross(pose.t);
    inverse_depth = -shift.dot(rotated) / shift.squaredNorm();
  }
};

/// Some of the inliers, and homography R + t n^T of the plane n^T X = 1 (in units of the translation) that most of them
/// lie on.
struct PlaneFit {
  std::array<PlaneEquation, kPlaneMatches> equations;
  std::array<double, kPlaneMatches> values;  ///< storage
  int inliers = 0, on_plane = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();

  PlaneFit(const PointColumnsView& points, const TwoViewPose& pose, const std::vector<float>& residuals);

 private:
  template <class Value>
  double medianOf(const Value& value) {
    for (int k = 0; k < inliers; ++k) values[static_cast<size_t>(k)] = value(static_cast<size_t>(k));
    std::nth_element(values.begin(), values.begin() + inliers / 2, values.begin() + inliers);
    return values[static_cast<size_t>(inliers / 2)];
  }
};

/// Reweighted least squares: first by how typical the depths are, by which wrong matches with long displacements stand
/// out, then by the distance from the plane.
PlaneFit::PlaneFit(const PointColumnsView& points, const TwoViewPose& pose, const std::vector<float>& residuals) {
  std::array<double, kPlaneMatches> squares;
  for (int slot = 0; slot < points.count; ++slot) {
    const float residual = residuals[static_cast<size_t>(slot)];
    if (!(residual < 1)) continue;
    squares[static_cast<size_t>(inliers)] = static_cast<double>(residual);
    equations[static_cast<size_t>(inliers++)] = PlaneEquation(points, slot, pose);
  }
  if (inliers < kFewestMatches) return;
  // Squared distance from the plane within which a match lies on it.
  const double near =
      std::min(kFarthestNear, kNearVariances * medianOf([&](size_t k) { return squares[k]; }) / kMedianOfSquare);
  const double median = medianOf([&](size_t k) { return equations[k].inverse_depth; });
  const double deviation =
      std::max(1e-12, medianOf([&](size_t k) { return std::abs(equations[k].inverse_depth - median); }));
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    on_plane = 0;
    for (int k = 0; k < inliers; ++k) {
      const PlaneEquation& equation = equations[static_cast<size_t>(k)];
      const double deviations = (equation.inverse_depth - median) / (kTypicalDeviations * deviation);
      const double e = equation.weight * (equation.rotated + equation.shift * normal.dot(equation.p)).squaredNorm();
      const double falloff = 1 / (1 + (iteration == 0 ? deviations * deviations : e / (near * kWidening[iteration])));
      on_plane += iteration > 0 && e < near;
      const double weight = falloff * falloff;
      A += weight * equation.shift.squaredNorm() * equation.p * equation.p.transpose();
      b -= weight * equation.shift.dot(equation.rotated) * equation.p;
    }
    points.countPasses(1);
    if (iteration > 1 && on_plane < kHopelessShare * inliers) break;
    normal = A.ldlt().solve(b);
  }
}

/// The motion of plane u1 or u2 of Ma et al., eq. 5.48, from the scaled homography and two orthogonal vectors that it
/// keeps in length.
TwoViewPose motionOf(const Eigen::Matrix3d& H, const Eigen::Vector3d& v, const Eigen::Vector3d& u) {
  Eigen::Matrix3d U, W;
  const Eigen::Vector3d normal = v.cross(u), Hv = H * v, Hu = H * u;
  U << v, u, normal;
  W << Hv, Hu, Hv.cross(Hu);
  const Eigen::Matrix3d R = W * U.transpose();
  return {R, ((H - R) * normal).normalized()};
}

}  // namespace

std::optional<TwoViewPose> findOtherPlaneMotion(const PoseModel& model, const TwoViewPose& pose,
                                                std::vector<float>& storage) {
  const PoseModel part = model.first(kPlaneMatches);
  part.residuals(pose, storage);
  const PlaneFit plane(part.points(), pose, storage);
  if (plane.inliers < kFewestMatches || plane.on_plane < kLeastShare * plane.inliers) return std::nullopt;
  Eigen::Matrix3d H = pose.R + pose.t * plane.normal.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(H.transpose() * H);
  const Eigen::Vector3d values = solver.eigenvalues() / solver.eigenvalues()[1];  // ascending
  if (!values.allFinite() || values[2] - values[0] < kLeastSpread) return std::nullopt;
  H /= std::sqrt(solver.eigenvalues()[1]);
  const Eigen::Vector3d v1 = solver.eigenvectors().col(2), v2 = solver.eigenvectors().col(1),
                        v3 = solver.eigenvectors().col(0);
  const double spread = std::sqrt(values[2] - values[0]);
  const Eigen::Vector3d along = std::sqrt(std::max(0.0, 1 - values[0])) / spread * v1;
  const Eigen::Vector3d across = std::sqrt(std::max(0.0, values[2] - 1)) / spread * v3;
  const TwoViewPose first = motionOf(H, v2, along + across), second = motionOf(H, v2, along - across);
  // The other one is that whose direction is further from the pose's.
  const TwoViewPose& other = std::abs(first.t.dot(pose.t)) < std::abs(second.t.dot(pose.t)) ? first : second;
  if (!other.R.allFinite() || !other.t.allFinite()) return std::nullopt;
  float cost;
  return model.withBetterSign(other, cost);
}

}  // namespace gms_ransac
