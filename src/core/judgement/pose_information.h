// Information of the matches of a pair on the pose and the camera's parameters, summed over each cell of the image and
// over all. Derived in doc/judgement.md.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_result.h"
#include "judgement/match_noise.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// The partition of the image that the judgement works with: matches of one cell err together and count as one
/// observation.
constexpr int kCellSide = kSpreadGridSide, kCellCount = kCellSide * kCellSide;

constexpr int kPoseParameters = DerivativeColumn::kPoseCount;
constexpr int kParameters = DerivativeColumn::kParameterCount;
constexpr int kCameraParameters = kParameters - kPoseParameters;

using PoseVector = Eigen::Matrix<double, kPoseParameters, 1>;
using PoseSquare = Eigen::Matrix<double, kPoseParameters, kPoseParameters>;
using ParameterVector = Eigen::Matrix<double, kParameters, 1>;
using PoseRows = Eigen::Matrix<double, kPoseParameters, kParameters>;
using ParameterSquare = Eigen::Matrix<double, kParameters, kParameters>;

/// Blocks of cells to a side of the image.
constexpr int kBlockSide = 5, kCellsOfBlock = kCellSide / kBlockSide;
static_assert(kCellSide % kBlockSide == 0, "blocks of whole cells");
inline int blockRow(int32_t cell) { return cell / kCellSide / kCellsOfBlock; }
inline int blockColumn(int32_t cell) { return cell % kCellSide / kCellsOfBlock; }
inline size_t blockOf(int32_t cell) {
  return static_cast<size_t>(blockRow(cell)) * kBlockSide + static_cast<size_t>(blockColumn(cell));
}

/// The matches of one cell, or of a block of them, that take part.
struct CellSums {
  int32_t cell = 0;  ///< of a block: one of its cells
  int count = 0;
  ParameterVector gradient = ParameterVector::Zero();  ///< of half the loss
  PoseSquare curvature = PoseSquare::Zero();           ///< second derivatives of half the loss by the pose
};

/// Parameters are those of PoseModel::linearize, then those of DerivativeColumn.
struct PoseInformation {
  int used = 0;                         ///< matches that take part
  ParameterVector gradient;             ///< sums over all cells
  ParameterSquare curvature;            ///< likewise
  ParameterSquare scatter;              ///< covariance of the gradient, from the cells (Liang & Zeger 1986)
  Eigen::Matrix2d line_turns;           ///< products of the angles by which the two steps of t rotate the lines, summed
  std::vector<CellSums> cells, blocks;  ///< those with matches
};

/// Sums up the matches of a pair. Keeps its storage.
class PoseSummation {
 public:
  /// `plausible`: the points, implausible ones without weight; `cells`: of each column.
  const PoseInformation& sum(const ResidualKernels& kernels, const PointColumnsView& plausible, const TwoViewPose& pose,
                             const Loss& loss, const std::vector<int32_t>& cells);
  /// The last sums.
  const PoseInformation& information() const { return information_; }
  /// The curvature by the pose and all parameters of the matches of each block.
  const std::array<PoseRows, kBlockSide * kBlockSide>& blockCurvatures();

 private:
  /// Entries that the kernels load at once, aligned as they ask for.
  struct alignas(kLanes * sizeof(float)) Entries {
    float lane[kLanes];
  };
  const float* column(int k) const { return columns_[static_cast<size_t>(k) * size_ / kLanes].lane; }
  float* column(int k) { return columns_[static_cast<size_t>(k) * size_ / kLanes].lane; }

  PoseInformation information_;
  size_t size_ = 0;               ///< of a column
  double bend_ = 1;               ///< mean second derivative of half the loss
  std::vector<Entries> columns_;  ///< DerivativeColumn
  std::vector<int> places_;       ///< in information_.cells, of each match that takes part; -1
  std::array<PoseRows, kBlockSide * kBlockSide> block_curvatures_;
};

}  // namespace gms_ransac
