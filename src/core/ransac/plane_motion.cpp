#include "ransac/plane_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace gms_ransac {

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
struct PlaneRow {
  Eigen::Vector3d p, rotated, shift;
  double weight, inverse_depth;

  PlaneRow() = default;
  PlaneRow(const PointColumnsView& points, int i, const TwoViewPose& pose)
      : p(points.x1[i], points.y1[i], 1), weight(points.weight[i]) {
    const Eigen::Vector3d q(points.x2[i], points.y2[i], 1);
    rotated = q.cross(pose.R * p);
    shift = q.cross(pose.t);
    inverse_depth = -shift.dot(rotated) / shift.squaredNorm();
  }
};

/// Some of the inliers, and homography R + t n^T of the plane n^T X = 1 (in units of the translation) that most of them
/// lie on.
struct PlaneFit {
  std::array<PlaneRow, kPlaneMatches> rows;
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
  for (int i = 0; i < points.count; ++i) {
    if (!(residuals[static_cast<size_t>(i)] < 1)) continue;
    squares[static_cast<size_t>(inliers)] = static_cast<double>(residuals[static_cast<size_t>(i)]);
    rows[static_cast<size_t>(inliers++)] = PlaneRow(points, i, pose);
  }
  if (inliers < kFewestMatches) return;
  // Squared distance from the plane within which a match lies on it.
  const double near =
      std::min(kFarthestNear, kNearVariances * medianOf([&](size_t k) { return squares[k]; }) / kMedianOfSquare);
  const double median = medianOf([&](size_t k) { return rows[k].inverse_depth; });
  const double deviation =
      std::max(1e-12, medianOf([&](size_t k) { return std::abs(rows[k].inverse_depth - median); }));
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    on_plane = 0;
    for (int k = 0; k < inliers; ++k) {
      const PlaneRow& row = rows[static_cast<size_t>(k)];
      const double deviations = (row.inverse_depth - median) / (kTypicalDeviations * deviation);
      const double e = row.weight * (row.rotated + row.shift * normal.dot(row.p)).squaredNorm();
      const double falloff = 1 / (1 + (iteration == 0 ? deviations * deviations : e / (near * kWidening[iteration])));
      on_plane += iteration > 0 && e < near;
      const double weight = falloff * falloff;
      A += weight * row.shift.squaredNorm() * row.p * row.p.transpose();
      b -= weight * row.shift.dot(row.rotated) * row.p;
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
