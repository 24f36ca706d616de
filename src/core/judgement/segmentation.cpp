#include "judgement/segmentation.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

constexpr int kSide = kBlockSide;
/// Drawn scenes of one rigid world, whose largest statistic is 13 in the median, exceed this in less than one of 100.
constexpr double kBreak = 27;
constexpr double kLeastShare = 0.1;  ///< of the matches, in the rectangle and outside
constexpr int kFewest = 15;          ///< matches

constexpr int kRounds = 4;  ///< in most scenes the third changes nothing
constexpr int kIterations = 10;
/// Two motions must cost less than this share of what one does; two that are fitted to one by chance come to 0.9.
constexpr double kMostCost = 0.9;

/// Sums over blocks in units of the whole's information, which then is the identity.
struct BlockSums {
  int count = 0;
  PoseVector gradient = PoseVector::Zero();
  PoseSquare curvature = PoseSquare::Zero(), scatter = PoseSquare::Zero();

  BlockSums& operator+=(const BlockSums& other) { return add(1, other); }
  BlockSums& operator-=(const BlockSums& other) { return add(-1, other); }

 private:
  BlockSums& add(int sign, const BlockSums& other) {
    count += sign * other.count;
    gradient += sign * other.gradient;
    curvature += sign * other.curvature;
    scatter += sign * other.scatter;
    return *this;
  }
};

/// The sums over all blocks above and to the left of a corner of the grid of blocks.
using CornerSums = std::array<std::array<BlockSums, kSide + 1>, kSide + 1>;

void sumUp(const PoseInformation& all, const Eigen::LLT<PoseSquare>& information, CornerSums& corners) {
  const auto whiten = [&](const PoseSquare& square) -> PoseSquare {
    const PoseSquare half = information.matrixL().solve(square);
    return information.matrixL().solve(PoseSquare(half.transpose()));
  };
  for (const CellSums& cell : all.cells) {
    const auto y = static_cast<size_t>(blockRow(cell.cell)) + 1, x = static_cast<size_t>(blockColumn(cell.cell)) + 1;
    const PoseVector gradient = cell.gradient.head<kPoseParameters>();
    BlockSums& block = corners[y][x];
    block.count += cell.count;
    block.gradient += gradient;
    block.curvature += cell.curvature;
    block.scatter += gradient * gradient.transpose();
  }
  for (size_t y = 1; y <= kSide; ++y) {
    for (size_t x = 1; x <= kSide; ++x) {
      BlockSums& sums = corners[y][x];
      sums.gradient = information.matrixL().solve(PoseVector(sums.gradient));
      sums.curvature = whiten(sums.curvature);
      sums.scatter = whiten(sums.scatter);
      sums += corners[y - 1][x];
      sums += corners[y][x - 1];
      sums -= corners[y - 1][x - 1];
    }
  }
}

/// Covariance of the gradient that remains in a part after the step of the whole to its optimum.
PoseSquare covarianceOf(const BlockSums& part, const PoseSquare& scatter) {
  const PoseSquare half = part.curvature * (part.scatter - 0.5 * scatter * part.curvature);
  return part.scatter - half - half.transpose();
}

/// The statistics of some rectangles with the camera free in excess and covariance, which mostly is not needed.
class CameraFreeTest {
 public:
  /// `inverse`: of the curvature by all parameters.
  CameraFreeTest(PoseSummation& summation, const ParameterSquare& inverse)
      : all_(summation.information()), inverse_(inverse), curvatures_(summation.blockCurvatures()) {
    for (PoseRows& block : scatters_) block.setZero();
    for (const CellSums& cell : all_.cells) {
      scatters_[blockOf(cell.cell)] += cell.gradient.head<kPoseParameters>() * cell.gradient.transpose();
    }
  }

  double statistic(const PoseBreak& region) const {
    PoseRows curvature = PoseRows::Zero(), scatter = PoseRows::Zero();
    PoseVector excess = PoseVector::Zero();
    for (int row = region.top; row < region.bottom; ++row) {
      for (int column = region.left; column < region.right; ++column) {
        const auto block = static_cast<size_t>(row) * kSide + static_cast<size_t>(column);
        curvature += curvatures_[block];
        scatter += scatters_[block];
      }
    }
    for (const CellSums& cell : all_.cells) {
      if (region.holds(cell.cell)) excess += cell.gradient.head<kPoseParameters>();
    }
    const PoseRows moved = curvature.lazyProduct(inverse_);
    excess -= moved * all_.gradient;
    const PoseSquare shared = moved.lazyProduct(scatter.transpose());
    const PoseRows whole = moved.lazyProduct(all_.scatter);
    const PoseSquare covariance = scatter.leftCols<kPoseParameters>() - shared - shared.transpose() +
                                  PoseSquare(whole.lazyProduct(moved.transpose()));
    return excess.dot(covariance.ldlt().solve(excess));
  }

 private:
  const PoseInformation& all_;
  const ParameterSquare& inverse_;
  const std::array<PoseRows, kSide * kSide>& curvatures_;
  std::array<PoseRows, kSide * kSide> scatters_;
};

}  // namespace

bool PoseBreak::holds(int32_t cell) const {
  const int row = blockRow(cell), column = blockColumn(cell);
  return row >= top && row < bottom && column >= left && column < right;
}

PoseBreak findBreak(PoseSummation& summation, const ParameterSquare& inverse) {
  const PoseInformation& all = summation.information();
  PoseBreak worst;
  const Eigen::LLT<PoseSquare> information(PoseSquare(all.curvature.topLeftCorner<kPoseParameters, kPoseParameters>()));
  if (information.info() != Eigen::Success) return worst;
  CornerSums corners;
  sumUp(all, information, corners);
  std::optional<CameraFreeTest> test;
  const BlockSums& whole = corners[kSide][kSide];
  for (int top = 0; top < kSide; ++top) {
    for (int bottom = top + 1; bottom <= kSide; ++bottom) {
      for (int left = 0; left < kSide; ++left) {
        for (int right = left + 1; right <= kSide; ++right) {
          const auto corner = [&](int y, int x) -> const BlockSums& {
            return corners[static_cast<size_t>(y)][static_cast<size_t>(x)];
          };
          const int count = corner(bottom, right).count - corner(top, right).count - corner(bottom, left).count +
                            corner(top, left).count;
          const int fewer = std::min(count, whole.count - count);
          if (fewer < kFewest || fewer < kLeastShare * whole.count) continue;
          BlockSums part = corner(bottom, right);
          part -= corner(top, right);
          part -= corner(bottom, left);
          part += corner(top, left);
          const PoseVector excess = part.gradient - part.curvature * whole.gradient;
          PoseBreak region = {0, left, top, right, bottom};
          // By the pose's own parameters first, which takes little and mostly settles it.
          const double seeming = excess.dot(covarianceOf(part, whole.scatter).ldlt().solve(excess));
          if (!(seeming > kBreak)) continue;
          if (!test) test.emplace(summation, inverse);
          region.statistic = test->statistic(region);
          if (region.statistic > worst.statistic) worst = region;
        }
      }
    }
  }
  return worst;
}

void Segmenter::segment(const TwoViewPoints& points, const TwoViewPose& pose, const MatchNoise& noise,
                        const PoseBreak& at, Segmentation& segmentation) {
  segmentation.found = false;
  if (!(at.statistic > kBreak)) return;
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
  if (!(two < kMostCost * one)) return;
  segmentation.found = true;
  const bool swapped = explained[1] > explained[0];
  if (swapped) {
    for (uint8_t& flag : apart) flag = 1 - flag;
  }
  segmentation.larger = bodies[swapped];
  segmentation.smaller_share = static_cast<double>(explained[!swapped]) / std::max(1, explained[swapped]);
}

}  // namespace gms_ransac
