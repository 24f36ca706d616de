#include "judgement/segmentation.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "judgement/refined_pose.h"

namespace gms_ransac {

namespace {

/// Drawn scenes of one rigid world, whose largest statistic is 13 in the median, exceed this in less than one of 100.
constexpr double kBreak = 27;
/// 2 of some 1400 OK answers on real images exceed it, Kinects in a hand among them.
constexpr double kTorn = 40;
constexpr double kLeastShare = 0.1;  ///< of the matches, in the rectangle and outside

constexpr int kRounds = 4;  ///< in most scenes the third changes nothing
/// Two motions must cost less than this share of what one does; two that are fitted to one by chance come to 0.9.
constexpr double kMostCostOfTwo = 0.9;

/// A part of the view in the score test that the whole asks for the same values of the first N parameters. Its gradient
/// and scatter are summed over cells; all of it adds up over parts that do not overlap.
template <int N>
struct BreakTest {
  using Rows = Eigen::Matrix<double, kPoseParameters, N>;
  int count = 0;
  PoseVector excess = PoseVector::Zero();  ///< of its gradient over what the step of the whole explains
  Rows share = Rows::Zero();               ///< by which it follows the gradient of the whole
  Rows crossed = Rows::Zero();             ///< half of share times the scatter of the whole, less its own scatter
  PoseSquare scatter = PoseSquare::Zero();

  void operator+=(const BreakTest& other) {
    count += other.count;
    excess += other.excess;
    share += other.share;
    crossed += other.crossed;
    scatter += other.scatter;
  }
  /// Chi-square; 0 if too few cells have matches.
  double statistic() const {
    const PoseSquare half = crossed.lazyProduct(share.transpose());
    const Eigen::LLT<PoseSquare> variance(scatter + half + half.transpose());
    return variance.info() == Eigen::Success ? excess.dot(variance.solve(excess)) : 0;
  }
};

constexpr size_t kRectangles = kBlockCount * (kBlockSide + 1) * (kBlockSide + 1) / 4;

/// Tests the rectangles in `broken` and clears those without a break. `inverse`: of the curvature by the first N
/// parameters.
template <int N>
PoseBreak worstBreak(const PoseInformation& all, const Eigen::Matrix<double, N, N>& inverse,
                     std::bitset<kRectangles>& broken) {
  using Test = BreakTest<N>;
  const Eigen::Matrix<double, N, N> half_scatter = 0.5 * all.scatter.topLeftCorner<N, N>();
  std::array<Test, kBlockCount> blocks;
  for (const PartSums& cell : all.cells) {
    const ParameterVector gradient = cell.gradient();
    Test& block = blocks[static_cast<size_t>(blockOf(cell.cell))];
    for (int k = 0; k < N; ++k) block.crossed.col(k) -= gradient[k] * gradient.head<kPoseParameters>();
  }
  for (size_t k = 0; k < blocks.size(); ++k) {
    const PartSums& sums = all.blocks[k];
    Test& block = blocks[k];
    block.count = sums.count;
    const Eigen::Matrix<float, N, kPoseParameters> products = sums.products.topLeftCorner<N, kPoseParameters>();
    block.share = all.bend * products.transpose().template cast<double>().lazyProduct(inverse);
    block.excess = sums.gradient().head<kPoseParameters>() - block.share * all.gradient.head<N>();
    block.scatter = -block.crossed.leftCols(kPoseParameters);
    block.crossed += block.share.lazyProduct(half_scatter);
  }
  PoseBreak worst;
  size_t rectangle = 0;
  for (int top = 0; top < kBlockSide; ++top) {
    std::array<Test, kBlockSide> columns;
    for (int bottom = top + 1; bottom <= kBlockSide; ++bottom) {
      const Test* last_row = &blocks[static_cast<size_t>(bottom - 1) * kBlockSide];
      for (Test& column : columns) column += *last_row++;
      for (int left = 0; left < kBlockSide; ++left) {
        Test part;
        for (int right = left + 1; right <= kBlockSide; ++right, ++rectangle) {
          part += columns[static_cast<size_t>(right - 1)];
          const int fewer = std::min(part.count, all.used - part.count);
          const bool enough = fewer >= kParameters && fewer >= kLeastShare * all.used;
          const double statistic = enough && broken[rectangle] ? part.statistic() : 0;
          broken[rectangle] = statistic > kBreak;
          if (statistic > worst.statistic) worst = {statistic, {left, top, right - left, bottom - top}, 0};
        }
      }
    }
  }
  return worst;
}

/// PoseBreak::weaker_side. `inverse`: of the curvature by the pose.
double weakerSide(const PoseInformation& all, const PoseSquare& inverse, const PoseBreak& at) {
  PoseSquare inside = PoseSquare::Zero();
  for (int k = 0; k < kBlockCount; ++k) {
    if (at.holds(k)) inside += all.bend * all.blocks[static_cast<size_t>(k)].ownProducts();
  }
  const auto sigma = [](const PoseSquare& curvature) {
    const PoseSquare covariance = inverseOf(curvature);
    return covariance.allFinite() ? directionSigma(covariance) : std::numeric_limits<double>::infinity();
  };
  return std::max(sigma(inside), sigma(all.ofPose() - inside)) / directionSigma(inverse);
}

}  // namespace

PoseBreak findBreak(const PoseInformation& all, double variance) {
  const PoseSquare inverse = inverseOf(all.ofPose());
  if (!inverse.allFinite()) return {};
  // By the pose's own parameters first, which takes little and mostly settles it.
  std::bitset<kRectangles> broken;
  const PoseBreak own = worstBreak<kPoseParameters>(all, inverse, broken.set());
  PoseBreak worst = broken.any() ? worstBreak<kParameters>(all, all.inverseWithCamera(variance), broken) : own;
  if (own.statistic > kTorn) worst.weaker_side = weakerSide(all, inverse, own);
  return worst;
}

void Segmentation::find(const RefinedPose& refined, TwoBodies& bodies) {
  const PoseBreak& at = refined.worst_break;
  std::vector<uint8_t>& of_other = bodies.of_other;
  if (!(at.statistic > kBreak)) return of_other.clear();
  const PoseModel model = refined.model();
  const PointColumnsView view = model.points();
  const std::vector<int32_t>& cells = refined.points->cells();
  of_other.resize(static_cast<size_t>(view.count));
  for (size_t slot = 0; slot < of_other.size(); ++slot) of_other[slot] = at.holds(blockOf(cells[slot]));
  TwoViewPose motions[2] = {refined.pose, refined.pose};
  for (int round = 0; round < kRounds; ++round) {
    for (int k = 0; k < 2; ++k) {
      own_.copy(view, [&](int slot) { return of_other[static_cast<size_t>(slot)] == k; });
      PoseModel(refined.kernels, own_.view()).refine(kRobustLoss, kFinalIterations, motions[k], kEnough);
      model.residualsInFront(motions[k], residuals_[k]);
    }
    second_worse_.assign(kCellCount, 0.f);
    for (size_t slot = 0; slot < of_other.size(); ++slot) {
      second_worse_[static_cast<size_t>(cells[slot])] +=
          std::min(residuals_[1][slot], 1.f) - std::min(residuals_[0][slot], 1.f);
    }
    for (size_t slot = 0; slot < of_other.size(); ++slot) {
      of_other[slot] = second_worse_[static_cast<size_t>(cells[slot])] < 0;
    }
  }
  double one = 0, two = 0;
  int explained[2] = {0, 0};
  for (size_t slot = 0; slot < of_other.size(); ++slot) {
    const float e = residuals_[of_other[slot]][slot];
    one += static_cast<double>(std::min(refined.noise.residuals()[slot], 1.f));
    two += static_cast<double>(std::min(e, 1.f));
    explained[of_other[slot]] += e < 1;
  }
  if (!(two < kMostCostOfTwo * one)) return of_other.clear();
  const bool swapped = explained[1] > explained[0];
  if (swapped) {
    for (uint8_t& flag : of_other) flag = 1 - flag;
  }
  bodies.larger = motions[swapped];
  bodies.smaller_share = static_cast<double>(explained[!swapped]) / std::max(1, explained[swapped]);
}

}  // namespace gms_ransac
