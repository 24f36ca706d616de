#include "judgement/pose_information.h"

#include <algorithm>

namespace gms_ransac {

namespace {

using Column = DerivativeColumn;

constexpr double kLeastCurvature = 0.05;  ///< of the loss, which has 1 at its bottom

}  // namespace

const PoseInformation& PoseSummation::sum(const ResidualKernels& kernels, const PointColumnsView& plausible,
                                          const TwoViewPose& pose, const Loss& loss,
                                          const std::vector<int32_t>& cells) {
  const auto size = static_cast<size_t>(plausible.size);
  columns_.resize(Column::kCount * size / kLanes);
  const auto column = [&](int k) { return columns_[static_cast<size_t>(k) * size / kLanes].lane; };
  const DerivativeSums sums = PoseModel(kernels, plausible).differentiate(pose, loss, column(0));
  PoseInformation& all = information_;
  all.used = sums.used;
  // The mean second derivative; each match's own is noisy, and negative in the tails.
  const double bend = std::max(static_cast<double>(sums.curvature) / std::max(1, sums.used), kLeastCurvature);
  double products[kParameters * (kParameters + 1) / 2];
  kernels.sumProducts(column(0), plausible.size, products);
  for (int i = 0, k = 0; i < kParameters; ++i) {
    for (int j = 0; j <= i; ++j, ++k) all.curvature(i, j) = all.curvature(j, i) = bend * products[k];
  }

  std::array<int, kCellCount> place_of_cell;
  place_of_cell.fill(-1);
  all.cells.clear();
  all.cells.reserve(kCellCount);
  all.blocks.fill({});
  using Rows = Eigen::Matrix<float, kPoseParameters, kParameters>;
  std::array<Rows, kBlockCount> curvatures;
  curvatures.fill(Rows::Zero());
  all.line_rotations.setZero();
  for (size_t i = 0; i < static_cast<size_t>(plausible.count); ++i) {
    // A match that takes part moves the direction of translation, if by ever so little.
    if (column(Column::kTranslation)[i] == 0 && column(Column::kTranslation + 1)[i] == 0) continue;
    int& place = place_of_cell[static_cast<size_t>(cells[i])];
    if (place < 0) {
      place = static_cast<int>(all.cells.size());
      all.cells.emplace_back().cell = cells[i];
    }
    CellSums& cell = all.cells[static_cast<size_t>(place)];
    const size_t block = blockOf(cells[i]);
    ++all.blocks[block].count;
    Eigen::Matrix<float, kParameters, 1> J;
    for (int k = 0; k < kParameters; ++k) J[k] = column(k)[i];
    const Rows curvature = J.head<kPoseParameters>() * J.transpose();
    curvatures[block] += curvature;
    cell.gradient += (column(Column::kPull)[i] * J).cast<double>();
    cell.curvature += curvature.leftCols<kPoseParameters>().cast<double>();
    const Eigen::Vector2d turn(column(Column::kLineRotation)[i], column(Column::kLineRotation + 1)[i]);
    all.line_rotations += turn * turn.transpose();
  }
  all.line_rotations *= bend;
  all.gradient.setZero();
  all.scatter.setZero();
  for (size_t k = 0; k < curvatures.size(); ++k) all.blocks[k].curvature = bend * curvatures[k].cast<double>();
  for (CellSums& cell : all.cells) {
    cell.curvature *= bend;
    all.gradient += cell.gradient;
    for (int k = 0; k < kParameters; ++k) all.scatter.col(k) += cell.gradient[k] * cell.gradient;
    BlockSums& block = all.blocks[blockOf(cell.cell)];
    block.gradient += cell.gradient;
    block.scatter += cell.gradient.head<kPoseParameters>() * cell.gradient.transpose();
  }
  const auto count = static_cast<double>(all.cells.size());
  all.scatter *= count / std::max(1., count - kPoseParameters);
  return all;
}

}  // namespace gms_ransac
