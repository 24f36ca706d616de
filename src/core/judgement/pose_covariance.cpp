#include "judgement/pose_covariance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "two_view/levenberg_marquardt.h"

namespace gms_ransac {

namespace {

constexpr double kLeastCurvature = 0.05;  ///< of the loss, which has 1 at its bottom
/// Largest share of the information on the direction that counts as noise. The noise itself is known to a few percent
/// only.
constexpr double kMostNoise = 0.9;
/// Negative eigenvalues that the rounding of an inverse may leave in a correlation matrix.
constexpr double kInversionTolerance = 1e-8;
constexpr double kMostAsymmetry = 1e-4;  ///< that it may leave there

/// Where fewer cells have matches, what neighbouring cells share is more than noise: each block is one observation
/// then.
constexpr size_t kEnoughCells = 100;

/// The matrix, unless it is the inverse of an ill-conditioned curvature, of which rounding errors decide: it is not
/// positive definite or not symmetric, or has a rotation that is less certain than any angle can be.
PoseSquare orIdentity(const PoseSquare& matrix) {
  const PoseVector variances = matrix.diagonal();
  if (!matrix.allFinite() || variances.minCoeff() < 0 || variances.head<3>().maxCoeff() > M_PI * M_PI) {
    return PoseSquare::Identity();
  }
  const PoseVector scale = variances.cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  PoseSquare correlation = scale.asDiagonal() * matrix * scale.asDiagonal();
  if (!(correlation - correlation.transpose()).isZero(kMostAsymmetry)) return PoseSquare::Identity();
  correlation.diagonal().setConstant(1 + kInversionTolerance);
  return Eigen::LLT<PoseSquare>(correlation).info() == Eigen::Success ? matrix : PoseSquare::Identity();
}

using Columns = Eigen::Ref<const Eigen::MatrixXd>;

/// Huber's sandwich, plus the square of the step from the pose to the optimum. `rows`: five, of the inverse of a
/// curvature. Not a template, because the compiler would spend seconds on each size.
PoseSquare sandwich(const Columns& rows, const Columns& scatter, const Columns& gradient) {
  Eigen::Matrix<double, kPoseParameters, Eigen::Dynamic, 0, kPoseParameters, kParameters> half;
  half = rows.lazyProduct(scatter);
  const PoseVector step = rows.lazyProduct(gradient);
  PoseSquare result = half.lazyProduct(rows.transpose());
  for (int k = 0; k < kPoseParameters; ++k) result.col(k) += step[k] * step;
  return result;
}

/// The curvature by the pose, without the information on the direction that noise of the points only seems to hold.
PoseSquare withoutFeigned(const PoseInformation& all, double variance) {
  PoseSquare told = all.ofPose();
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
PoseSquare scatterWithoutLeverage(const PoseInformation& all, const std::vector<PartSums>& parts) {
  const PoseSquare curvature = all.ofPose();
  PoseSquare steps = PoseSquare::Zero();
  for (const PartSums& part : parts) {
    if (part.count == 0) continue;
    double others[kPoseParameters * (kPoseParameters + 1) / 2], pull[kPoseParameters], of_others[kPoseParameters];
    for (int i = 0, k = 0; i < kPoseParameters; ++i) {
      pull[i] = static_cast<double>(part.products(i, kPoseParameters));
      for (int j = i; j < kPoseParameters; ++j, ++k) {
        others[k] = curvature(i, j) - all.bend * static_cast<double>(part.products(i, j));
      }
    }
    if (!solveDamped<kPoseParameters>(others, pull, 0, of_others)) return PoseSquare::Constant(NAN);
    const Eigen::Map<const PoseVector> step(of_others);
    for (int k = 0; k < kPoseParameters; ++k) steps.col(k) += step[k] * step;
  }
  return sandwich(curvature, steps, PoseVector::Zero());
}

/// Covariance where nothing in the image moves, so that the curvature by the direction is zero: that of the rotation.
PoseSquare ofRotationAlone(const PoseInformation& all) {
  const Eigen::LLT<Eigen::Matrix3d> factors(Eigen::Matrix3d(all.curvature.topLeftCorner<3, 3>()));
  if (factors.info() != Eigen::Success) return PoseSquare::Identity();
  PoseSquare inverse = PoseSquare::Zero();
  inverse.topLeftCorner<3, 3>() = factors.solve(Eigen::Matrix3d::Identity());
  PoseSquare result = sandwich(inverse, all.scatter.topLeftCorner<kPoseParameters, kPoseParameters>(),
                               all.gradient.head<kPoseParameters>());
  result.bottomRightCorner<2, 2>().setIdentity();
  return orIdentity(result);
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

}  // namespace

const CameraVector& typicalCameraError() {
  static const CameraVector sigma =
      (CameraVector() << 0.03, 0.01, 0.01, 0.03, Eigen::Matrix<double, 6, 1>::Constant(2 * M_PI / 180)).finished();
  return sigma;
}

PoseSquare inverseOf(const PoseSquare& curvature) {
  const Eigen::LLT<PoseSquare> factors(curvature);
  if (factors.info() != Eigen::Success) return PoseSquare::Constant(NAN);
  return factors.solve(PoseSquare::Identity());
}

ParameterSquare PoseInformation::inverseWithCamera(double variance) const {
  ParameterSquare information = curvature;
  information.diagonal().tail<kCameraParameters>() += variance * typicalCameraError().cwiseAbs2().cwiseInverse();
  return information.llt().solve(ParameterSquare::Identity());
}

void PoseInformation::sum(const ResidualKernels& kernels, const PointColumnsView& plausible, const TwoViewPose& pose,
                          const Loss& loss, const std::vector<int32_t>& cell_of) {
  columns_.resize(DerivativeColumn::kCount, plausible.size);
  const DerivativeSums sums = PoseModel(kernels, plausible).differentiate(pose, loss, columns_.column(0));
  used = sums.used;
  // The mean second derivative; each match's own is noisy, and negative in the tails.
  bend = std::max(static_cast<double>(sums.curvature) / std::max(1, used), kLeastCurvature);
  double products[kParameters * (kParameters + 1) / 2];
  kernels.sumProducts(columns_.column(0), plausible.size, products);
  for (int i = 0, k = 0; i < kParameters; ++i) {
    for (int j = 0; j <= i; ++j, ++k) curvature(i, j) = curvature(j, i) = bend * products[k];
  }
  using Angles = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 2>>;
  const Angles angles(columns_.column(DerivativeColumn::kLineRotation), plausible.size, 2);
  line_rotations = bend * angles.transpose().lazyProduct(angles).cast<double>();
  sumParts(plausible.count, cell_of);
}

void PoseInformation::sumParts(int count, const std::vector<int32_t>& cell_of) {
  std::array<int, kCellCount> place_of_cell;
  place_of_cell.fill(-1);
  cells.clear();
  cells.reserve(kCellCount);
  const float* columns[DerivativeColumn::kParameterCount];
  for (int k = 0; k < DerivativeColumn::kParameterCount; ++k) columns[k] = columns_.column(k);
  const float* pulls = columns_.column(DerivativeColumn::kPull);
  Eigen::Matrix<float, kLanes, 1> J = Eigen::Matrix<float, kLanes, 1>::Zero();
  for (int slot = 0; slot < count; ++slot) {
    for (int k = 0; k < DerivativeColumn::kParameterCount; ++k) J[k] = columns[k][slot];
    // A match that takes part moves the direction of translation, if by ever so little.
    if (J[DerivativeColumn::kTranslation] == 0 && J[DerivativeColumn::kTranslation + 1] == 0) continue;
    const int32_t cell = cell_of[static_cast<size_t>(slot)];
    int& place = place_of_cell[static_cast<size_t>(cell)];
    if (place < 0) {
      place = static_cast<int>(cells.size());
      cells.emplace_back().cell = cell;
    }
    PartSums& part = cells[static_cast<size_t>(place)];
    ++part.count;
    for (int k = 0; k < kPoseParameters; ++k) part.products.col(k) += J[k] * J;
    part.products.col(kPoseParameters) += pulls[slot] * J;
  }
  blocks.assign(kBlockCount, {});
  gradient.setZero();
  scatter.setZero();
  for (const PartSums& cell : cells) {
    const ParameterVector own = cell.gradient();
    gradient += own;
    for (int k = 0; k < kParameters; ++k) scatter.col(k) += own[k] * own;
    PartSums& block = blocks[static_cast<size_t>(blockOf(cell.cell))];
    block.count += cell.count;
    block.products += cell.products;
  }
  const auto observations = static_cast<double>(cells.size());
  scatter *= observations / std::max(1., observations - kPoseParameters);
}

double directionSigma(const PoseSquare& covariance) {
  const Eigen::Matrix2d direction = covariance.bottomRightCorner<2, 2>();
  const double half_trace = 0.5 * direction.trace();
  return std::sqrt(half_trace + std::sqrt(std::max(0.0, half_trace * half_trace - direction.determinant())));
}

PoseCovariance poseCovariance(const PoseInformation& all, double variance, double calibration_sigma) {
  PoseCovariance result;
  if (all.used < kParameters) return result;
  const PoseVector gradient = all.gradient.head<kPoseParameters>();
  const PoseSquare naive = inverseOf(all.ofPose()), inverse = inverseOf(withoutFeigned(all, variance));
  if (!naive.allFinite() || !inverse.allFinite()) {
    result.covariance = result.of_matches = ofRotationAlone(all);
    return result;
  }
  const PoseSquare by_cells = scatterWithoutLeverage(all, all.cells);
  result.of_matches = sandwich(inverse, by_cells, gradient);
  if (all.cells.size() < kEnoughCells) {
    const PoseVector scale = widening(sandwich(naive, by_cells, gradient),
                                      sandwich(naive, scatterWithoutLeverage(all, all.blocks), gradient));
    result.of_matches = scale.asDiagonal() * result.of_matches * scale.asDiagonal();
  }

  result.camera = testCamera(all, naive);
  CameraSquare errors = result.camera.second_moment;
  errors.diagonal().head<3>().array() += calibration_sigma * calibration_sigma;
  const Eigen::Matrix<double, kPoseParameters, kCameraParameters> effect =
      naive.lazyProduct(all.curvature.topRightCorner<kPoseParameters, kCameraParameters>());
  result.covariance = orIdentity(result.of_matches + sandwich(effect, errors, CameraVector::Zero()));
  return result;
}

Covariance6d relativeCovariance(const TwoViewPose& pose, const PoseSquare& covariance) {
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
