#include "judgement/plane_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

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

/// Homography R + t n^T of the plane n^T X = 1 (in units of the translation) that most of the inliers lie on.
struct PlaneFit {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  int inliers = 0, on_plane = 0;
};

/// What the plane's normal gets from a match: q x (R + t n^T) p = 0 is rotated + shift (n . p) = 0, linear in n.
struct PlaneRow {
  Eigen::Vector3d p, rotated, shift;
  double weight;

  PlaneRow(const PointColumnsView& points, int i, const TwoViewPose& pose)
      : p(points.x1[i], points.y1[i], 1), weight(points.weight[i]) {
    const Eigen::Vector3d q(points.x2[i], points.y2[i], 1);
    rotated = q.cross(pose.R * p);
    shift = q.cross(pose.t);
  }
  double inverseDepth() const { return -shift.dot(rotated) / shift.squaredNorm(); }
};

/// Squared distance from the plane within which a match lies on it.
double nearPlane(const PointColumnsView& points, const std::vector<float>& residuals) {
  std::array<float, kPlaneMatches> squares;
  size_t count = 0;
  for (int i = 0; i < points.count; ++i) {
    if (residuals[static_cast<size_t>(i)] < 1) squares[count++] = residuals[static_cast<size_t>(i)];
  }
  if (count == 0) return kFarthestNear;
  const auto middle = squares.begin() + static_cast<int>(count / 2);
  std::nth_element(squares.begin(), middle, squares.begin() + static_cast<int>(count));
  return std::min(kFarthestNear, kNearVariances * static_cast<double>(*middle) / kMedianOfSquare);
}

/// Median and median deviation of the inverse depths, by which wrong matches with long displacements stand out.
std::pair<double, double> typicalInverseDepth(const PointColumnsView& points, const TwoViewPose& pose,
                                              const std::vector<float>& residuals) {
  std::array<double, kPlaneMatches> depths;
  size_t count = 0;
  for (int i = 0; i < points.count; ++i) {
    if (residuals[static_cast<size_t>(i)] < 1) depths[count++] = PlaneRow(points, i, pose).inverseDepth();
  }
  if (count == 0) return {0, 1};
  const auto middle = depths.begin() + static_cast<int>(count / 2), end = depths.begin() + static_cast<int>(count);
  std::nth_element(depths.begin(), middle, end);
  const double median = *middle;
  for (auto depth = depths.begin(); depth != end; ++depth) *depth = std::abs(*depth - median);
  std::nth_element(depths.begin(), middle, end);
  return {median, std::max(*middle, 1e-12)};
}

/// Reweighted least squares: first by how typical the depths are, then by the distance from the plane.
PlaneFit fitPlane(const PointColumnsView& points, const TwoViewPose& pose, const std::vector<float>& residuals,
                  int64_t& evaluations) {
  PlaneFit plane;
  const double near = nearPlane(points, residuals);
  const auto [median, deviation] = typicalInverseDepth(points, pose, residuals);
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    plane.inliers = plane.on_plane = 0;
    for (int i = 0; i < points.count; ++i) {
      if (!(residuals[static_cast<size_t>(i)] < 1)) continue;
      const PlaneRow row(points, i, pose);
      double falloff;
      if (iteration == 0) {
        const double deviations = (row.inverseDepth() - median) / (kTypicalDeviations * deviation);
        falloff = 1 / (1 + deviations * deviations);
      } else {
        const double e = row.weight * (row.rotated + row.shift * plane.normal.dot(row.p)).squaredNorm();
        falloff = 1 / (1 + e / (near * kWidening[iteration]));
        plane.on_plane += e < near;
      }
      const double weight = falloff * falloff;
      A += weight * row.shift.squaredNorm() * row.p * row.p.transpose();
      b -= weight * row.shift.dot(row.rotated) * row.p;
      ++plane.inliers;
    }
    evaluations += points.count;
    if (iteration > 1 && plane.on_plane < kHopelessShare * plane.inliers) break;
    plane.normal = A.ldlt().solve(b);
  }
  return plane;
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

bool findOtherPlaneMotion(const PointColumnsView& points, const TwoViewPose& pose, const std::vector<float>& residuals,
                          TwoViewPose& other, int64_t& evaluations) {
  // The two motions of a plane (Faugeras & Lustman 1988) by the closed form of Ma et al. 2004, section 5.3.3; the other
  // is the one whose direction is further from that of `pose`.
  const PlaneFit plane = fitPlane(firstColumns(points, kPlaneMatches), pose, residuals, evaluations);
  if (plane.inliers < kFewestMatches || plane.on_plane < kLeastShare * plane.inliers) return false;
  Eigen::Matrix3d H = pose.R + pose.t * plane.normal.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(H.transpose() * H);
  const Eigen::Vector3d values = solver.eigenvalues() / solver.eigenvalues()[1];  // ascending
  if (!values.allFinite() || values[2] - values[0] < kLeastSpread) return false;
  H /= std::sqrt(solver.eigenvalues()[1]);
  const Eigen::Vector3d v1 = solver.eigenvectors().col(2), v2 = solver.eigenvectors().col(1),
                        v3 = solver.eigenvectors().col(0);
  const double spread = std::sqrt(values[2] - values[0]);
  const Eigen::Vector3d along = std::sqrt(std::max(0.0, 1 - values[0])) / spread * v1;
  const Eigen::Vector3d across = std::sqrt(std::max(0.0, values[2] - 1)) / spread * v3;
  const TwoViewPose first = motionOf(H, v2, along + across), second = motionOf(H, v2, along - across);
  other = std::abs(first.t.dot(pose.t)) < std::abs(second.t.dot(pose.t)) ? first : second;
  return other.R.allFinite() && other.t.allFinite();
}

}  // namespace gms_ransac
