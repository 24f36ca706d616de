#include "gms/distance_consistency.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "random.h"

namespace gms_ransac {

namespace {

constexpr double kSigmas = 3.0;
constexpr double kMadToSigma = 1.4826;  ///< of a normal distribution
constexpr float kLeastTolerance = 3.f;  ///< pixels
constexpr int kPartners = 8;
constexpr float kRatioTolerance = 0.2f;

float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void DistanceConsistency::apply(const Features& reference, const Features& current, const std::vector<Match>& matches,
                                MotionStatistics& statistics) {
  survivors_.clear();
  from_.clear();
  to_.clear();
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!statistics.accepted[i]) continue;
    survivors_.push_back(static_cast<int>(i));
    from_.push_back(reference.keypoints[matches[i].reference].pt);
    to_.push_back(current.keypoints[matches[i].current].pt);
  }
  if (survivors_.empty()) return;
  if (reading_ == DistanceReading::kDisplacement) {
    applyDisplacement(statistics);
  } else {
    applyPairwise(statistics);
  }
}

void DistanceConsistency::applyDisplacement(MotionStatistics& statistics) {
  const int columns = statistics.grid_columns, rows = statistics.grid_rows;
  length_.resize(survivors_.size());
  by_cell_.resize(survivors_.size());
  cell_begin_.assign(static_cast<size_t>(columns) * rows + 1, 0);
  for (size_t k = 0; k < survivors_.size(); ++k) {
    length_[k] = std::hypot(to_[k].x - from_[k].x, to_[k].y - from_[k].y);
    ++cell_begin_[statistics.cell[survivors_[k]]];
  }
  for (size_t cell = 1; cell < cell_begin_.size(); ++cell) cell_begin_[cell] += cell_begin_[cell - 1];
  for (size_t k = 0; k < survivors_.size(); ++k) {
    by_cell_[--cell_begin_[statistics.cell[survivors_[k]]]] = static_cast<int>(k);
  }

  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int cell = row * columns + column;
      if (cell_begin_[cell] == cell_begin_[cell + 1]) continue;
      pool_.clear();
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
        const int first = y * columns + std::max(column - 1, 0), last = y * columns + std::min(column + 1, columns - 1);
        for (int i = cell_begin_[first]; i < cell_begin_[last + 1]; ++i) pool_.push_back(length_[by_cell_[i]]);
      }
      const float middle = median(pool_);
      for (float& length : pool_) length = std::fabs(length - middle);
      const auto tolerance = std::max(kLeastTolerance, static_cast<float>(kSigmas * kMadToSigma * median(pool_)));
      for (int i = cell_begin_[cell]; i < cell_begin_[cell + 1]; ++i) {
        if (std::fabs(length_[by_cell_[i]] - middle) > tolerance) reject(by_cell_[i], statistics);
      }
    }
  }
}

void DistanceConsistency::applyPairwise(MotionStatistics& statistics) {
  const int n = static_cast<int>(survivors_.size());
  if (n < 2) return;
  Random random(seed_);
  ratio_.resize(n);
  for (int k = 0; k < n; ++k) {
    pool_.clear();
    for (int i = 0; i < kPartners; ++i) {
      const int partner = (k + 1 + random.below(n - 1)) % n;
      const float before = std::hypot(from_[k].x - from_[partner].x, from_[k].y - from_[partner].y);
      const float after = std::hypot(to_[k].x - to_[partner].x, to_[k].y - to_[partner].y);
      if (before > 0) pool_.push_back(after / before);
    }
    ratio_[k] = pool_.empty() ? -1.f : median(pool_);  // all partners at the same place: no evidence, dropped
  }
  pool_ = ratio_;
  const float common = median(pool_);
  for (int k = 0; k < n; ++k) {
    if (!(std::fabs(ratio_[k] - common) <= kRatioTolerance * common)) reject(k, statistics);
  }
}

void DistanceConsistency::reject(size_t survivor, MotionStatistics& statistics) const {
  const int match = survivors_[survivor];
  statistics.accepted[match] = 0;
  statistics.score[match] = 0;
  statistics.relative_score[match] = 0.f;
  --statistics.accepted_count;
}

}  // namespace gms_ransac
