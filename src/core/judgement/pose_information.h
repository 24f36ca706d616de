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
constexpr int kBlockSide = 5, kBlockCount = kBlockSide * kBlockSide, kCellsOfBlock = kCellSide / kBlockSide;
static_assert(kCellSide % kBlockSide == 0, "blocks of whole cells");
inline int blockRow(int32_t cell) { return cell / kCellSide / kCellsOfBlock; }
inline int blockColumn(int32_t cell) { return cell % kCellSide / kCellsOfBlock; }
inline size_t blockOf(int32_t cell) {
  const int block = blockRow(cell) * kBlockSide + blockColumn(cell);
  return static_cast<size_t>(block);
}

/// The matches of one cell that take part. Gradient and curvature are the derivatives of half the loss.
struct CellSums {
  int32_t cell = 0;
  ParameterVector gradient = ParameterVector::Zero();
  PoseSquare curvature = PoseSquare::Zero();  ///< by the pose twice
};

struct BlockSums {
  int count = 0;  ///< matches
  ParameterVector gradient = ParameterVector::Zero();
  PoseRows curvature = PoseRows::Zero();  ///< by the pose and all parameters
  PoseRows scatter = PoseRows::Zero();    ///< sum over the cells of the products of their gradients

  BlockSums& operator+=(const BlockSums& other) {
    count += other.count;
    gradient += other.gradient;
    curvature += other.curvature;
    scatter += other.scatter;
    return *this;
  }
};

/// Parameters are those of PoseModel::linearize, then those of DerivativeColumn.
struct PoseInformation {
  int used = 0;                    ///< matches that take part
  ParameterVector gradient;        ///< sums over all cells
  ParameterSquare curvature;       ///< the same
  ParameterSquare scatter;         ///< covariance of the gradient, from the cells (Liang & Zeger 1986)
  Eigen::Matrix2d line_rotations;  ///< products of the angles by which the two steps of t rotate the lines, summed
  std::vector<CellSums> cells;     ///< those with matches
  std::array<BlockSums, kBlockCount> blocks;
};

/// Sums up the matches of a pair. Keeps its storage.
class PoseSummation {
 public:
  /// `plausible`: the points, implausible ones without weight; `cells`: of each column.
  const PoseInformation& sum(const ResidualKernels& kernels, const PointColumnsView& plausible, const TwoViewPose& pose,
                             const Loss& loss, const std::vector<int32_t>& cells);
  /// The last sums.
  const PoseInformation& information() const { return information_; }

 private:
  /// Entries that the kernels load at once, aligned as they ask for.
  struct alignas(kLanes * sizeof(float)) Entries {
    float lane[kLanes];
  };

  PoseInformation information_;
  std::vector<Entries> columns_;  ///< DerivativeColumn
};

}  // namespace gms_ransac
