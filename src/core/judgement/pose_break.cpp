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

/// The squared Mahalanobis distance from 0 of what a region's gradient is beyond its share of the whole's step. Of N
/// parameters, the pose first.
template <int N>
double statistic(const Eigen::Matrix<double, PoseBreakTest::kPose, N>& information,
                 const Eigen::Matrix<double, PoseBreakTest::kPose, N>& scatter,
                 const Eigen::Matrix<double, PoseBreakTest::kPose, 1>& gradient,
                 const Eigen::Matrix<double, N, N>& inverse, const Eigen::Matrix<double, N, N>& spread,
                 const Eigen::Matrix<double, N, 1>& step) {
  constexpr int kPose = PoseBreakTest::kPose;
  using Pose = Eigen::Matrix<double, kPose, 1>;
  using Square = Eigen::Matrix<double, kPose, kPose>;
  using Rows = Eigen::Matrix<double, kPose, N>;
  const Pose excess = gradient - information * step;
  const Rows moved = information * inverse;
  const Square shared = moved * scatter.transpose();
  const Square covariance =
      scatter.template leftCols<kPose>() - shared - shared.transpose() + information * spread * information.transpose();
  return excess.dot(covariance.ldlt().solve(excess));
}

}  // namespace

bool PoseBreak::holds(int32_t cell) const {
  const int row = blockRow(cell), column = blockColumn(cell);
  return row >= top && row < bottom && column >= left && column < right;
}

PoseBreakTest::Sums& PoseBreakTest::Sums::operator+=(const Sums& other) {
  count += other.count;
  information += other.information;
  scatter += other.scatter;
  gradient += other.gradient;
  return *this;
}

PoseBreakTest::Sums& PoseBreakTest::Sums::operator-=(const Sums& other) {
  count -= other.count;
  information -= other.information;
  scatter -= other.scatter;
  gradient -= other.gradient;
  return *this;
}

void PoseBreakTest::clear() {
  for (auto& row : table_) row.fill(Sums());
  for (auto& row : information_) row.fill(Eigen::Matrix<float, kPose, kAll>::Zero());
}

void PoseBreakTest::addMatch(int32_t cell, const Eigen::Matrix<float, kAll, 1>& derivatives) {
  ++blockOf(cell, table_).count;
  blockOf(cell, information_).noalias() += derivatives.head<kPose>() * derivatives.transpose();
}

void PoseBreakTest::addCell(int32_t cell, const Parameters& gradient) {
  Sums& sums = blockOf(cell, table_);
  sums.scatter.noalias() += gradient.head<kPose>() * gradient.transpose();
  sums.gradient += gradient.head<kPose>();
}

Eigen::Matrix<double, PoseBreakTest::kPose, PoseBreakTest::kPose> PoseBreakTest::jackknife(
    const Eigen::Matrix<double, kPose, kPose>& curvature, const Eigen::Matrix<double, kPose, 1>& step) const {
  using Square = Eigen::Matrix<double, kPose, kPose>;
  Square sum = Square::Zero();
  int blocks = 0;
  for (size_t y = 1; y <= kSide; ++y) {
    for (size_t x = 1; x <= kSide; ++x) {
      if (table_[y][x].count == 0) continue;
      ++blocks;
      const Square own = information_[y][x].leftCols<kPose>().cast<double>();
      const Eigen::LDLT<Square> others(curvature - own);
      if (others.info() != Eigen::Success || !others.isPositive()) return Square::Identity();  // nothing without it
      const Eigen::Matrix<double, kPose, 1> change = others.solve(table_[y][x].gradient - own * step);
      sum += change * change.transpose();
    }
  }
  return (blocks - 1.) / std::max(1, blocks) * sum;
}

void PoseBreakTest::sumUp() {
  for (size_t y = 1; y <= kSide; ++y) {
    for (size_t x = 1; x <= kSide; ++x) {
      table_[y][x].information = information_[y][x].cast<double>();
      table_[y][x] += table_[y - 1][x];
      table_[y][x] += table_[y][x - 1];
      table_[y][x] -= table_[y - 1][x - 1];
    }
  }
}

template <class Value, class Take>
Value PoseBreakTest::within(const PoseBreak& region, const Take& take) const {
  const auto at = [&](int y, int x) -> decltype(auto) {
    return take(table_[static_cast<size_t>(y)][static_cast<size_t>(x)]);
  };
  return at(region.bottom, region.right) - at(region.top, region.right) - at(region.bottom, region.left) +
         at(region.top, region.left);
}

template <int N>
double PoseBreakTest::statisticOf(const PoseBreak& region, const Eigen::Matrix<double, N, N>& inverse,
                                  const Eigen::Matrix<double, N, N>& spread,
                                  const Eigen::Matrix<double, N, 1>& step) const {
  using Rows = Eigen::Matrix<double, kPose, N>;
  using Pose = Eigen::Matrix<double, kPose, 1>;
  return statistic<N>(within<Rows>(region, [](const Sums& sums) { return sums.information.leftCols<N>(); }),
                      within<Rows>(region, [](const Sums& sums) { return sums.scatter.leftCols<N>(); }),
                      within<Pose>(region, [](const Sums& sums) -> const Pose& { return sums.gradient; }), inverse,
                      spread, step);
}

PoseBreak PoseBreakTest::find(const Whole& inverse, const Whole& scatter, const Parameters& gradient) {
  sumUp();
  const Parameters step = inverse * gradient;
  const Whole spread = inverse * scatter * inverse;
  const Sums& all = table_[kSide][kSide];
  // Without the camera's parameters first, which takes a tenth of the time and mostly settles it.
  using Pose = Eigen::Matrix<double, kPose, 1>;
  using Square = Eigen::Matrix<double, kPose, kPose>;
  const Square pose_inverse = Square(all.information.leftCols<kPose>()).ldlt().solve(Square::Identity());
  const Square pose_spread = pose_inverse * scatter.topLeftCorner<kPose, kPose>() * pose_inverse;
  const Pose pose_step = pose_inverse * gradient.head<kPose>();

  PoseBreak best, region;
  for (region.top = 0; region.top < kSide; ++region.top) {
    for (region.bottom = region.top + 1; region.bottom <= kSide; ++region.bottom) {
      for (region.left = 0; region.left < kSide; ++region.left) {
        for (region.right = region.left + 1; region.right <= kSide; ++region.right) {
          const int count = within<int>(region, [](const Sums& sums) { return sums.count; });
          const int fewer = std::min(count, all.count - count);
          if (fewer < kFewest || fewer < kLeastShare * all.count) continue;
          region.statistic = statisticOf<kPose>(region, pose_inverse, pose_spread, pose_step);
          if (!region.found()) continue;
          region.statistic = statisticOf<kAll>(region, inverse, spread, step);
          if (region.statistic > best.statistic) best = region;
        }
      }
    }
  }
  return best;
}

}  // namespace gms_ransac
