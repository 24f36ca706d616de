#include "judgement/pose_information.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

using Column = DerivativeColumn;

constexpr double kFocalError = 0.03, kPrincipalError = 0.01, kRadialError = 0.03, kReadoutError = 2 * M_PI / 180;
constexpr double kLeastCurvature = 0.05;  ///< of the loss, which has 1 at its bottom

}  // namespace

const CameraVector& typicalCameraError() {
  static const CameraVector sigma =
      (CameraVector() << kFocalError, kPrincipalError, kPrincipalError, kRadialError, kReadoutError, kReadoutError,
       kReadoutError, kReadoutError, kReadoutError, kReadoutError)
          .finished();
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
  columns_.resize(Column::kCount, plausible.size);
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
  const Angles angles(columns_.column(Column::kLineRotation), plausible.size, 2);
  line_rotations = bend * angles.transpose().lazyProduct(angles).cast<double>();
  sumParts(plausible.count, cell_of);
}

void PoseInformation::sumParts(int count, const std::vector<int32_t>& cell_of) {
  std::array<int, kCellCount> place_of_cell;
  place_of_cell.fill(-1);
  cells.clear();
  cells.reserve(kCellCount);
  const float* columns[Column::kParameterCount];
  for (int k = 0; k < Column::kParameterCount; ++k) columns[k] = columns_.column(k);
  const float* pulls = columns_.column(Column::kPull);
  Eigen::Matrix<float, kLanes, 1> J = Eigen::Matrix<float, kLanes, 1>::Zero();
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < Column::kParameterCount; ++k) J[k] = columns[k][i];
    // A match that takes part moves the direction of translation, if by ever so little.
    if (J[Column::kTranslation] == 0 && J[Column::kTranslation + 1] == 0) continue;
    const int32_t cell = cell_of[static_cast<size_t>(i)];
    int& place = place_of_cell[static_cast<size_t>(cell)];
    if (place < 0) {
      place = static_cast<int>(cells.size());
      cells.emplace_back().cell = cell;
    }
    PartSums& part = cells[static_cast<size_t>(place)];
    ++part.count;
    for (int k = 0; k < kPoseParameters; ++k) part.products.col(k) += J[k] * J;
    part.products.col(kPoseParameters) += pulls[i] * J;
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

}  // namespace gms_ransac
