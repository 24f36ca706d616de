// Tests if one explanation of the matches is better than another by more than chance.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "gms_ransac/point_pairs.h"

namespace gms_ransac {

/// Limit of the statistic if mostly chance decides which explanation fits better: a quantile of the normal
/// distribution.
constexpr double kSurelyBetter = 2.5;

constexpr float kMostCost = 9;  ///< of a wrong match, in squared standard deviations: three of them

/// The statistic of Vuong's test of non-nested models (Econometrica 1989). It is the sum over `count` matches of the
/// cost of the second model minus that of the first, over the root of the sum of squares, not centred. Each cell of the
/// spread grid is one observation, because its matches have correlated errors. At most the root of the number of cells.
/// `difference(i)`: of match i; `cells`: of each match; `by_cell`: storage.
template <class Difference>
double vuongStatistic(int count, const std::vector<int32_t>& cells, std::vector<double>& by_cell,
                      const Difference& difference) {
  by_cell.assign(static_cast<size_t>(kSpreadGridSide) * kSpreadGridSide, 0.0);
  double sum = 0, squares = 0;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const auto excess = static_cast<double>(difference(i));
    by_cell[static_cast<size_t>(cells[i])] += excess;
    sum += excess;
  }
  for (const double excess : by_cell) squares += excess * excess;
  return squares > 0 ? sum / std::sqrt(squares) : 0;
}

}  // namespace gms_ransac
