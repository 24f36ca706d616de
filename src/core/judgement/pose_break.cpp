#include "judgement/pose_break.h"

#include <algorithm>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

constexpr int kSide = PoseBreak::kSide, kCellsOfBlock = kSpreadGridSide / kSide;
static_assert(kSpreadGridSide % kSide == 0, "blocks of whole cells");
constexpr double kLeastShare = 0.1;  ///< of the matches, in the region and outside
constexpr int kFewest = 15;          ///< matches

int blockRow(int32_t cell) { return cell / kSpreadGridSide / kCellsOfBlock; }
int blockColumn(int32_t cell) { return cell % kSpreadGridSide / kCellsOfBlock; }

template <class Table>
auto& blockOf(int32_t cell, Table& table) {
  return table[static_cast<size_t>(blockRow(cell)) + 1][static_cast<size_t>(blockColumn(cell)) + 1];
}

constexpr int kPose = BlockSums<5>::kPose;
using Pose = Eigen::Matrix<double, kPose, 1>;
using Square = Eigen::Matrix<double, kPose, kPose>;

/// The squared Mahalanobis distance of `excess` from 0, by factors without pivots.
double squaredDistance(const Square& covariance, const Pose& excess) {
  constexpr double kLost = 1e-9;  ///< of a pivot: what is left of its entry is rounding
  Square rest = covariance;
  Pose e = excess;
  double sum = 0;
  for (int j = 0; j < kPose; ++j) {
    if (!(rest(j, j) > kLost * covariance(j, j))) return excess.dot(covariance.ldlt().solve(excess));
    const double inverse = 1 / rest(j, j);
    sum += e[j] * e[j] * inverse;
    for (int i = j + 1; i < kPose; ++i) {
      const double factor = rest(i, j) * inverse;
      e[i] -= factor * e[j];
      for (int k = j + 1; k <= i; ++k) rest(i, k) -= factor * rest(k, j);
    }
  }
  return sum;
}

}  // namespace

bool PoseBreak::holds(int32_t cell) const {
  const int row = blockRow(cell), column = blockColumn(cell);
  return row >= top && row < bottom && column >= left && column < right;
}

template <int N>
typename BlockSums<N>::Sums& BlockSums<N>::Sums::operator+=(const Sums& other) {
  count += other.count;
  information += other.information;
  scatter += other.scatter;
  gradient += other.gradient;
  return *this;
}

template <int N>
typename BlockSums<N>::Sums& BlockSums<N>::Sums::operator-=(const Sums& other) {
  count -= other.count;
  information -= other.information;
  scatter -= other.scatter;
  gradient -= other.gradient;
  return *this;
}

template <int N>
void BlockSums<N>::clear() {
  for (auto& row : table_) row.fill(Sums());
  for (auto& row : information_) row.fill(BlockInformation::Zero());
}

template <int N>
void BlockSums<N>::addMatch(int32_t cell, const Derivatives& derivatives) {
  ++blockOf(cell, table_).count;
  for (int row = 0; row < kPose; ++row) blockOf(cell, information_).row(row) += derivatives[row] * derivatives;
}

template <int N>
void BlockSums<N>::addCell(int32_t cell, const Parameters& gradient) {
  Sums& sums = blockOf(cell, table_);
  sums.scatter.noalias() += gradient.template head<kPose>() * gradient.transpose();
  sums.gradient += gradient.template head<kPose>();
}

template <int N>
Eigen::Matrix<double, BlockSums<N>::kPose, BlockSums<N>::kPose> BlockSums<N>::jackknife(
    const Eigen::Matrix<double, kPose, kPose>& curvature, const Eigen::Matrix<double, kPose, 1>& step) const {
  Square sum = Square::Zero();
  int blocks = 0;
  for (size_t y = 1; y <= kSide; ++y) {
    for (size_t x = 1; x <= kSide; ++x) {
      if (table_[y][x].count == 0) continue;
      ++blocks;
      const Square own = information_[y][x].template leftCols<kPose>().template cast<double>();
      const Eigen::LDLT<Square> others(curvature - own);
      if (others.info() != Eigen::Success || !others.isPositive()) return Square::Identity();  // nothing without it
      const Pose change = others.solve(table_[y][x].gradient - own * step);
      sum += change * change.transpose();
    }
  }
  return (blocks - 1.) / std::max(1, blocks) * sum;
}

template <int N>
void BlockSums<N>::sumUp() {
  for (size_t y = 1; y <= kSide; ++y) {
    for (size_t x = 1; x <= kSide; ++x) {
      table_[y][x].information = information_[y][x].template leftCols<N>().template cast<double>();
      table_[y][x] += table_[y - 1][x];
      table_[y][x] += table_[y][x - 1];
      table_[y][x] -= table_[y - 1][x - 1];
    }
  }
}

template <int N>
int BlockSums<N>::countWithin(const PoseBreak& region) const {
  return above(region.bottom, region.right).count - above(region.top, region.right).count -
         above(region.bottom, region.left).count + above(region.top, region.left).count;
}

template <int N>
typename BlockSums<N>::Sums BlockSums<N>::within(const PoseBreak& region) const {
  const Sums &all = above(region.bottom, region.right), &over = above(region.top, region.right),
             &beside = above(region.bottom, region.left), &both = above(region.top, region.left);
  Sums sums;
  sums.information = all.information - over.information - beside.information + both.information;
  sums.scatter = all.scatter - over.scatter - beside.scatter + both.scatter;
  sums.gradient = all.gradient - over.gradient - beside.gradient + both.gradient;
  return sums;
}

template <int N>
void BlockSums<N>::findSuspects(const Square& scatter, const Pose& gradient, std::vector<PoseBreak>& suspects) {
  suspects.clear();
  sumUp();
  const Sums& all = above(kSide, kSide);
  const Square inverse = Square(all.information.template leftCols<kPose>()).ldlt().solve(Square::Identity());
  const Pose step = inverse * gradient;
  PoseBreak region;
  for (region.top = 0; region.top < kSide; ++region.top) {
    for (region.bottom = region.top + 1; region.bottom <= kSide; ++region.bottom) {
      for (region.left = 0; region.left < kSide; ++region.left) {
        for (region.right = region.left + 1; region.right <= kSide; ++region.right) {
          const int count = countWithin(region), fewer = std::min(count, all.count - count);
          if (fewer < kFewest || fewer < kLeastShare * all.count) continue;
          // As in worstOf, with half of the symmetric part on either side.
          const Sums own = within(region);
          const Square information = own.information.template leftCols<kPose>();
          const Square own_scatter = own.scatter.template leftCols<kPose>();
          const Square moved = information * inverse;
          const Square half = moved * (own_scatter - 0.5 * scatter * moved.transpose());
          region.statistic = squaredDistance(own_scatter - half - half.transpose(), own.gradient - information * step);
          if (region.found()) suspects.push_back(region);
        }
      }
    }
  }
}

template <int N>
PoseBreak BlockSums<N>::worstOf(const std::vector<PoseBreak>& suspects, const Whole& inverse, const Whole& scatter,
                                const Parameters& gradient) {
  sumUp();
  const Parameters step = inverse * gradient;
  const Whole spread = inverse * scatter * inverse;
  PoseBreak worst;
  for (PoseBreak region : suspects) {
    // What the region's gradient is beyond its share of the whole's step.
    const Sums own = within(region);
    const Pose excess = own.gradient - own.information * step;
    const Part moved = own.information * inverse;
    const Square shared = moved * own.scatter.transpose();
    const Square covariance = own.scatter.template leftCols<kPose>() - shared - shared.transpose() +
                              own.information * spread * own.information.transpose();
    region.statistic = excess.dot(covariance.ldlt().solve(excess));
    if (region.found() && region.statistic > worst.statistic) worst = region;
  }
  return worst;
}

template class BlockSums<5>;
template class BlockSums<15>;

}  // namespace gms_ransac
