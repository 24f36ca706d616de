#include "judgement/pose_covariance.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace gms_ransac {

namespace {

/// Largest share of the information on the direction that counts as noise. The noise itself is known to a few percent
/// only.
constexpr double kMostNoise = 0.9;
/// Between these contradictions the camera's parameters become free in the weight of a preferred rotation.
constexpr double kFirstDoubt = 0.5, kFullDoubt = 0.9;
/// Negative eigenvalues that the rounding of an inverse may leave in a correlation matrix.
constexpr double kInversionTolerance = 1e-8;

/// Where fewer cells have matches, what neighbouring cells share is more than noise: each block is one observation
/// then.
constexpr size_t kEnoughCells = 100;

using ByCamera = Eigen::Matrix<double, kPoseParameters, kCameraParameters>;

/// Not finite where the information does not suffice.
PoseSquare inverseOf(const PoseSquare& information) {
  const Eigen::LLT<PoseSquare> factors(information);
  if (factors.info() != Eigen::Success) return PoseSquare::Constant(NAN);
  return factors.solve(PoseSquare::Identity());
}

/// False for the inverse of an ill-conditioned curvature, of which rounding errors decide: it is not positive definite,
/// or has a rotation that is less certain than any angle can be.
bool isCovariance(const PoseSquare& matrix) {
  if (!matrix.allFinite() || matrix.diagonal().minCoeff() < 0) return false;
  if (matrix.diagonal().head<3>().maxCoeff() > M_PI * M_PI) return false;
  const PoseVector scale = matrix.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  PoseSquare correlation = scale.asDiagonal() * matrix * scale.asDiagonal();
  correlation.diagonal().setConstant(1 + kInversionTolerance);
  return Eigen::LLT<PoseSquare>(correlation).info() == Eigen::Success;
}

/// Huber's sandwich, plus the square of the step from the pose to the optimum.
PoseSquare sandwich(const PoseSquare& inverse, const PoseSquare& scatter, const PoseVector& gradient) {
  const PoseVector step = inverse * gradient;
  return inverse * scatter * inverse + step * step.transpose();
}

/// The curvature by the pose, less the part of the direction's that noise of the points feigns.
PoseSquare withoutFeigned(const PoseInformation& all, double variance) {
  PoseSquare told = all.curvature.topLeftCorner<kPoseParameters, kPoseParameters>();
  // Information on the direction if the rotation is unknown.
  const Eigen::Matrix<double, 3, 2> shared = told.topRightCorner<3, 2>();
  const Eigen::Matrix3d of_rotation = told.topLeftCorner<3, 3>();
  const Eigen::Matrix2d alone = told.bottomRightCorner<2, 2>() - shared.transpose() * of_rotation.llt().solve(shared);
  const Eigen::Matrix2d noise = variance * all.line_rotations;
  // Largest generalised eigenvalue of the two, over the determinant of the latter.
  const double half_trace =
      0.5 * (noise(0, 0) * alone(1, 1) + noise(1, 1) * alone(0, 0) - 2 * noise(0, 1) * alone(0, 1));
  const double determinant = noise.determinant() * alone.determinant();
  const double share =
      (half_trace + std::sqrt(std::max(0., half_trace * half_trace - determinant))) / alone.determinant();
  if (share > 0) told.bottomRightCorner<2, 2>() -= std::min(1., kMostNoise / share) * noise;
  return told;
}

/// Scatter of the gradients of cells or blocks, each at the pose that the others make: a part bends the pose towards
/// itself and shows only what its leverage leaves (CR3 of Bell & McCaffrey 2002).
template <class Parts>
PoseSquare scatterWithoutLeverage(const Parts& parts, const PoseSquare& inverse) {
  PoseSquare scatter = PoseSquare::Zero();
  for (const auto& part : parts) {
    const PoseSquare leverage = part.curvature.template leftCols<kPoseParameters>() * inverse;
    const PoseVector own = part.gradient.template head<kPoseParameters>();
    const PoseVector gradient = (PoseSquare::Identity() - leverage).partialPivLu().solve(own);
    scatter += gradient * gradient.transpose();
  }
  return scatter;
}

/// Covariance where nothing in the image moves, so that the curvature by the direction is zero: that of the rotation.
PoseSquare ofRotationAlone(const PoseInformation& all) {
  const Eigen::LLT<Eigen::Matrix3d> factors(Eigen::Matrix3d(all.curvature.topLeftCorner<3, 3>()));
  if (factors.info() != Eigen::Success) return PoseSquare::Constant(NAN);
  const Eigen::Matrix3d inverse = factors.solve(Eigen::Matrix3d::Identity());
  const Eigen::Vector3d step = inverse * all.gradient.head<3>();
  PoseSquare result = PoseSquare::Identity();
  result.topLeftCorner<3, 3>() = inverse * all.scatter.topLeftCorner<3, 3>() * inverse + step * step.transpose();
  return result;
}

/// Scale of a covariance by cells to the variance that blocks show, summed over the rotation or over the direction,
/// where that is more.
PoseVector widening(const PoseSquare& by_cells, const PoseSquare& by_blocks) {
  const PoseVector blocks = by_blocks.allFinite() ? PoseVector(by_blocks.diagonal()) : PoseVector::Ones();
  const auto scale = [&](int first, int count) {
    return std::sqrt(
        std::max(1., blocks.segment(first, count).sum() / by_cells.diagonal().segment(first, count).sum()));
  };
  PoseVector result;
  result << Eigen::Vector3d::Constant(scale(0, 3)), Eigen::Vector2d::Constant(scale(3, 2));
  return result;
}

/// Inverse of the curvature with the camera unknown up to its typical errors.
ParameterSquare inverseWithCamera(const PoseInformation& all, double variance) {
  ParameterSquare information = all.curvature;
  information.diagonal().tail<kCameraParameters>() += variance * typicalCameraError().cwiseAbs2().cwiseInverse();
  return information.llt().solve(ParameterSquare::Identity());
}

}  // namespace

double directionSigma(const PoseSquare& covariance) {
  const Eigen::Matrix2d direction = covariance.bottomRightCorner<2, 2>();
  const double half_trace = 0.5 * direction.trace();
  return std::sqrt(half_trace + std::sqrt(std::max(0.0, half_trace * half_trace - direction.determinant())));
}

PoseCovariance poseCovariance(const PoseInformation& all, const TwoViewPose& pose, double sigma,
                              double calibration_sigma) {
  PoseCovariance result;
  if (all.used < kParameters) return result;
  const double variance = sigma * sigma;
  const PoseVector gradient = all.gradient.head<kPoseParameters>();
  const PoseSquare naive = inverseOf(all.curvature.topLeftCorner<kPoseParameters, kPoseParameters>());
  const PoseSquare inverse = inverseOf(withoutFeigned(all, variance));
  if (!naive.allFinite() || !inverse.allFinite()) {
    const PoseSquare rotation = ofRotationAlone(all);
    if (isCovariance(rotation)) result.covariance = result.of_matches = result.naive = rotation;
    return result;
  }
  result.naive = sandwich(naive, all.scatter.topLeftCorner<kPoseParameters, kPoseParameters>(), gradient);
  const PoseSquare by_cells = scatterWithoutLeverage(all.cells, naive);
  result.of_matches = sandwich(inverse, by_cells, gradient);
  if (all.cells.size() < kEnoughCells) {
    const PoseVector scale = widening(sandwich(naive, by_cells, gradient),
                                      sandwich(naive, scatterWithoutLeverage(all.blocks, naive), gradient));
    result.of_matches = scale.asDiagonal() * result.of_matches * scale.asDiagonal();
  }

  const ByCamera by_camera = all.curvature.topRightCorner<kPoseParameters, kCameraParameters>();
  result.camera = testCamera(all, inverse, naive, pose);
  const ByCamera effect = naive * by_camera;
  result.covariance = result.of_matches + effect * result.camera.second_moment * effect.transpose();

  result.with_camera = inverseWithCamera(all, variance);
  ParameterSquare scatter = all.scatter;
  scatter.diagonal().tail<kCameraParameters>() += variance * variance * typicalCameraError().cwiseAbs2().cwiseInverse();
  const Eigen::Matrix<double, kPoseParameters, kParameters> rows = result.with_camera.topRows<kPoseParameters>();
  const PoseVector step = rows * all.gradient;
  PoseSquare any_camera = rows.lazyProduct(scatter).eval().lazyProduct(rows.transpose());
  any_camera += step * step.transpose();
  const double doubt = std::clamp((result.camera.statistic - kFirstDoubt) / (kFullDoubt - kFirstDoubt), 0.0, 1.0);
  result.naive += doubt * (any_camera - result.naive);

  const Eigen::Matrix<double, kPoseParameters, 3> calibration = calibration_sigma * inverse * by_camera.leftCols<3>();
  for (PoseSquare* covariance : {&result.covariance, &any_camera, &result.naive}) {
    *covariance += calibration * calibration.transpose();
    if (!isCovariance(*covariance)) covariance->setIdentity();
  }
  result.direction_sigma_any_camera = directionSigma(any_camera);
  return result;
}

Eigen::Matrix<double, 6, 6> relativeCovariance(const TwoViewPose& pose, const PoseSquare& covariance) {
  // With R' = R^T and t' = -R^T t: R' <- exp(-R^T w) R', and t' <- t' - R^T [t]x w - R^T (step).
  Eigen::Vector3d basis[2];
  PoseModel::tangent(pose.t, basis);
  const Eigen::Matrix3d Rt = pose.R.transpose();
  Eigen::Matrix<double, 6, 5> J = Eigen::Matrix<double, 6, 5>::Zero();
  J.topLeftCorner<3, 3>() = -Rt * crossMatrix(pose.t);
  for (int k = 0; k < 2; ++k) J.block<3, 1>(0, 3 + k) = -Rt * basis[k];
  J.bottomLeftCorner<3, 3>() = -Rt;
  return J * covariance * J.transpose();
}

}  // namespace gms_ransac
