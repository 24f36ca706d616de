#include "judgement/segmentation.h"

#include <algorithm>
#include <array>
#include <utility>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

/// Drawn scenes of one rigid world, whose largest statistic is 13 in the median, exceed this in less than one of 100.
constexpr double kBreak = 27;
constexpr double kLeastShare = 0.1;  ///< of the matches, in the rectangle and outside
constexpr int kFewest = 15;          ///< matches

constexpr int kRounds = 4;  ///< in most scenes the third changes nothing
constexpr int kIterations = 10;
/// Two motions must cost less than this share of what one does; two that are fitted to one by chance come to 0.9.
constexpr double kMostCost = 0.9;

/// Score test that a part of the view asks for the same values of the first kCount parameters as the whole. `inverse`:
/// of the curvature by them.
template <int kCount>
double breakStatistic(const BlockSums& part, const PoseInformation& all,
                      const Eigen::Matrix<double, kCount, kCount>& inverse) {
  using Rows = Eigen::Matrix<double, kPoseParameters, kCount>;
  const Rows moved = part.curvature.leftCols<kCount>().lazyProduct(inverse);
  const PoseVector excess = part.gradient.head<kPoseParameters>() - moved * all.gradient.head<kCount>();
  const PoseSquare shared = moved.lazyProduct(part.scatter.leftCols<kCount>().transpose());
  const Rows whole = moved.lazyProduct(all.scatter.topLeftCorner<kCount, kCount>());
  const PoseSquare covariance = part.scatter.leftCols<kPoseParameters>() - shared - shared.transpose() +
                                PoseSquare(whole.lazyProduct(moved.transpose()));
  return excess.dot(covariance.ldlt().solve(excess));
}

}  // namespace

bool PoseBreak::holds(int32_t cell) const {
  const int row = blockRow(cell), column = blockColumn(cell);
  return row >= top && row < bottom && column >= left && column < right;
}

PoseBreak findBreak(const PoseInformation& all, const ParameterSquare& inverse) {
  PoseBreak worst;
  const Eigen::LLT<PoseSquare> information(PoseSquare(all.curvature.topLeftCorner<kPoseParameters, kPoseParameters>()));
  if (information.info() != Eigen::Success) return worst;
  const PoseSquare own_inverse = information.solve(PoseSquare::Identity());
  for (int top = 0; top < kBlockSide; ++top) {
    std::array<BlockSums, kBlockSide> columns;
    for (int bottom = top + 1; bottom <= kBlockSide; ++bottom) {
      const int last = (bottom - 1) * kBlockSide;
      const BlockSums* last_row = &all.blocks[static_cast<size_t>(last)];
      for (BlockSums& column : columns) column += *last_row++;
      for (int left = 0; left < kBlockSide; ++left) {
        BlockSums part;
        for (int right = left + 1; right <= kBlockSide; ++right) {
          part += columns[static_cast<size_t>(right - 1)];
          const int fewer = std::min(part.count, all.used - part.count);
          if (fewer < kFewest || fewer < kLeastShare * all.used) continue;
          // By the pose's own parameters first, which takes little and mostly settles it.
          if (!(breakStatistic<kPoseParameters>(part, all, own_inverse) > kBreak)) continue;
          const double statistic = breakStatistic<kParameters>(part, all, inverse);
          if (statistic > worst.statistic) worst = {statistic, left, top, right, bottom};
        }
      }
    }
  }
  return worst;
}

void Segmenter::segment(const TwoViewPoints& points, const TwoViewPose& pose, const MatchNoise& noise,
                        const PoseBreak& at, Segmentation& segmentation) {
  if (!(at.statistic > kBreak)) return segmentation.apart.clear();
  const PointColumnsView view = points.view();
  const std::vector<int32_t>& cells = points.cells();
  std::vector<uint8_t>& apart = segmentation.apart;
  apart.resize(static_cast<size_t>(view.count));
  for (size_t i = 0; i < apart.size(); ++i) apart[i] = at.holds(cells[i]);
  TwoViewPose bodies[2] = {pose, pose};
  for (int round = 0; round < kRounds; ++round) {
    for (int k = 0; k < 2; ++k) {
      own_.copy(view, [&](int i) { return apart[static_cast<size_t>(i)] == k; });
      PoseModel(kernels_, own_.view()).refine(kRobustLoss, kIterations, bodies[k], kEnough);
      PoseModel(kernels_, view).residualsInFront(bodies[k], residuals_[k]);
    }
    second_worse_.assign(kCellCount, 0.f);
    for (size_t i = 0; i < apart.size(); ++i) {
      second_worse_[static_cast<size_t>(cells[i])] += std::min(residuals_[1][i], 1.f) - std::min(residuals_[0][i], 1.f);
    }
    for (size_t i = 0; i < apart.size(); ++i) apart[i] = second_worse_[static_cast<size_t>(cells[i])] < 0;
  }
  double one = 0, two = 0;
  int explained[2] = {0, 0};
  for (size_t i = 0; i < apart.size(); ++i) {
    const float e = residuals_[apart[i]][i];
    one += static_cast<double>(std::min(noise.residuals()[i], 1.f));
    two += static_cast<double>(std::min(e, 1.f));
    explained[apart[i]] += e < 1;
  }
  if (!(two < kMostCost * one)) return apart.clear();
  const bool swapped = explained[1] > explained[0];
  if (swapped) {
    for (uint8_t& flag : apart) flag = 1 - flag;
  }
  segmentation.larger = bodies[swapped];
  segmentation.smaller_share = static_cast<double>(explained[!swapped]) / std::max(1, explained[swapped]);
}

}  // namespace gms_ransac
