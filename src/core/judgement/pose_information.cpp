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
  size_ = size;
  const DerivativeSums sums = PoseModel(kernels, plausible).differentiate(pose, loss, column(0));
  PoseInformation& all = information_;
  all.used = sums.used;
  // The mean second derivative; each match's own is noisy, and negative in the tails.
  bend_ = std::max(static_cast<double>(sums.curvature) / std::max(1, sums.used), kLeastCurvature);
  double products[kParameters * (kParameters + 1) / 2];
  kernels.sumProducts(column(0), plausible.size, products);
  for (int i = 0, k = 0; i < kParameters; ++i) {
    for (int j = 0; j <= i; ++j, ++k) all.curvature(i, j) = all.curvature(j, i) = bend_ * products[k];
  }

  std::array<int, kCellCount> place_of_cell;
  place_of_cell.fill(-1);
  places_.assign(size, -1);
  all.cells.clear();
  all.cells.reserve(kCellCount);
  all.line_turns.setZero();
  for (size_t i = 0; i < static_cast<size_t>(plausible.count); ++i) {
    // A match that takes part moves the direction of translation, if by ever so little.
    if (column(Column::kTranslation)[i] == 0 && column(Column::kTranslation + 1)[i] == 0) continue;
    int& place = place_of_cell[static_cast<size_t>(cells[i])];
    if (place < 0) {
      place = static_cast<int>(all.cells.size());
      all.cells.emplace_back().cell = cells[i];
    }
    places_[i] = place;
    CellSums& cell = all.cells[static_cast<size_t>(place)];
    ++cell.count;
    float J[kParameters];
    for (int k = 0; k < kParameters; ++k) J[k] = column(k)[i];
    const float pull = column(Column::kPull)[i];
    for (int k = 0; k < kParameters; ++k) cell.gradient[k] += static_cast<double>(pull * J[k]);
    for (int k = 0; k < kPoseParameters; ++k) {
      for (int m = 0; m <= k; ++m) cell.curvature(k, m) += static_cast<double>(J[k] * J[m]);
    }
    const Eigen::Vector2d turn(column(Column::kLineTurn)[i], column(Column::kLineTurn + 1)[i]);
    all.line_turns += turn * turn.transpose();
  }
  all.line_turns *= bend_;
  all.gradient.setZero();
  all.scatter.setZero();
  for (CellSums& cell : all.cells) {
    cell.curvature *= bend_;
    for (int k = 0; k < kPoseParameters; ++k) {
      for (int m = 0; m < k; ++m) cell.curvature(m, k) = cell.curvature(k, m);
    }
    all.gradient += cell.gradient;
    for (int k = 0; k < kParameters; ++k) all.scatter.col(k) += cell.gradient[k] * cell.gradient;
  }
  all.blocks.clear();
  all.blocks.reserve(kBlockSide * kBlockSide);
  std::array<int, kBlockSide * kBlockSide> place_of_block;
  place_of_block.fill(-1);
  for (const CellSums& cell : all.cells) {
    int& place = place_of_block[blockOf(cell.cell)];
    if (place < 0) {
      place = static_cast<int>(all.blocks.size());
      all.blocks.emplace_back().cell = cell.cell;
    }
    CellSums& block = all.blocks[static_cast<size_t>(place)];
    block.count += cell.count;
    block.gradient += cell.gradient;
    block.curvature += cell.curvature;
  }
  const auto count = static_cast<double>(all.cells.size());
  all.scatter *= count / std::max(1., count - kPoseParameters);
  return all;
}

const std::array<PoseRows, kBlockSide * kBlockSide>& PoseSummation::blockCurvatures() {
  for (PoseRows& block : block_curvatures_) block.setZero();
  for (size_t i = 0; i < places_.size(); ++i) {
    if (places_[i] < 0) continue;
    PoseRows& block = block_curvatures_[blockOf(information_.cells[static_cast<size_t>(places_[i])].cell)];
    for (int k = 0; k < kParameters; ++k) {
      const float derivative = column(k)[i];
      for (int m = 0; m < kPoseParameters; ++m) block(m, k) += bend_ * static_cast<double>(column(m)[i] * derivative);
    }
  }
  return block_curvatures_;
}

}  // namespace gms_ransac
