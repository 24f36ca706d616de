#include "trust/trust_row.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "run/metrics.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Standard deviation along the worst axis, degrees.
template <typename Matrix>
double worstDeviation(const Matrix& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(covariance, Eigen::EigenvaluesOnly);
  return kDegrees * std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

/// What the truth says of an answer.
void judge(const RobustResult& result, Status status, const PoseTruth& truth, TrustRow& row) {
  if (!result.pose_found) return;
  const RelativePose& pose = result.pose;
  const Vector3d error = rotationVector(pose.R * truth.pose.linear().transpose());
  row.rx_deg = kDegrees * error.x();
  row.ry_deg = kDegrees * error.y();
  row.rz_deg = kDegrees * error.z();
  row.rotation_error_deg = (kDegrees * error).norm();
  const PairNoise noise(truth.noise, truth.clock_step, truth.pose);
  row.nees_rotation = normalizedSquare(error, pose.covariance.bottomRightCorner<3, 3>() + noise.rotation);

  const bool ok = status == Status::kOk;
  if (row.moved && !pose.t.isZero()) {
    const Vector3d t = pose.t.normalized();
    const TangentError tangent =
        tangentError(t, truth.pose.translation() / row.baseline_m,
                     pose.covariance.topLeftCorner<3, 3>() + noise.translation / std::pow(row.baseline_m, 2));
    row.direction_error_deg = kDegrees * tangent.error.norm();
    if (ok) row.nees_direction = normalizedSquare(tangent.error, tangent.covariance);
  }
  const bool rotation_right = row.rotation_error_deg <= truth.limits.rotation;
  row.right = rotation_right && (!row.moved || row.direction_error_deg <= truth.limits.direction);
  // An answer that is OK claims a direction: where the camera is known to have stood there is none.
  const bool stood = !row.moved && truth.noise.translation == 0;
  row.wrong = ok && (!row.right || stood);
}

/// What an answer says of itself.
void state(const RobustResult& result, Status status, TrustRow& row) {
  const auto& covariance = result.pose.covariance;
  row.rotation_sigma_deg = worstDeviation(Matrix3d(covariance.bottomRightCorner<3, 3>()));
  if (status == Status::kOk) row.direction_sigma_deg = worstDeviation(Matrix3d(covariance.topLeftCorner<3, 3>()));
  row.uncertainty_deg = row.rotation_sigma_deg + row.direction_sigma_deg;
  row.parallax_px = result.median_parallax_px;
  row.sigma_px = result.sigma_px;
  for (int i = 0; i < 36; ++i) row.covariance.push_back(covariance(i / 6, i % 6));
}

}  // namespace

double normalizedSquare(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  const Eigen::LDLT<Eigen::MatrixXd> factors(covariance);
  const bool invertible = factors.info() == Eigen::Success && factors.isPositive() && factors.vectorD().minCoeff() > 0;
  if (!invertible) return std::numeric_limits<double>::quiet_NaN();
  return error.dot(factors.solve(error)) / static_cast<double>(error.size());
}

TangentError tangentError(const Vector3d& estimate, const Vector3d& truth, const Matrix3d& covariance) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = estimate.unitOrthogonal();
  basis.col(1) = estimate.cross(basis.col(0));
  const double angle = std::atan2(estimate.cross(truth).norm(), estimate.dot(truth));
  const Vector2d across = basis.transpose() * truth;
  const double length = across.norm();
  // Exactly behind, any side will do.
  const Vector2d side = length > 0 ? Vector2d(across / length) : Vector2d(1, 0);
  return {angle * side, basis.transpose() * covariance * basis};
}

void Reliability::add(double probability, bool right) {
  const double clamped = std::clamp(probability, 0.0, 1.0);
  Bin& bin = bins[std::min<size_t>(kBins - 1, static_cast<size_t>(clamped * kBins))];
  ++bin.count;
  bin.probability += clamped;
  bin.right += right;
}

TrustRow makeTrustRow(const TrustContext& context, const RobustResult& result, const PoseTruth* truth,
                      const Reliability& reliability) {
  TrustRow row;
  row.kind = context.kind;
  row.set = context.set;
  row.gap = context.gap;
  row.pair = context.pair;
  row.method = context.method;
  row.status = toString(context.status);
  row.survivors = context.survivors;
  row.inliers = result.inlier_count;
  row.reliability = reliability;
  row.has_truth = truth != nullptr;
  if (truth) {
    row.baseline_m = truth->pose.translation().norm();
    row.moved = hasMoved(row.baseline_m, truth->noise);
  }
  if (context.status != Status::kOk && context.status != Status::kLowParallax) return row;
  state(result, context.status, row);
  if (truth) judge(result, context.status, *truth, row);
  return row;
}

}  // namespace gms_ransac
