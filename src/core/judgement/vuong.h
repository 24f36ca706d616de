// Tests if one explanation of the matches is better than another by more than chance.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "gms_ransac/point_pairs.h"

namespace gms_ransac {

/// What the statistic must reach where chance mostly decides which explanation fits better: a quantile of the normal
/// distribution.
constexpr double kSurelyBetter = 2.5;

/// The statistic of Vuong's test of non-nested models (Econometrica 1989): the sum over `count` matches of how much
/// more the second model costs than the first, over the root of the sum of its squares, not centred, each cell of the
/// spread grid counted as one observation, because its matches err together. At most the root of the number of cells.
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
