#include "gms/distance_consistency.h"

#include <algorithm>
#include <cmath>

#include "support/random.h"

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

struct Survivor {
  size_t raw;            ///< of the raw matches
  cv::Point2f from, to;  ///< pixels
};

float distance(const cv::Point2f& a, const cv::Point2f& b) { return std::hypot(b.x - a.x, b.y - a.y); }

void reject(const Survivor& survivor, MotionStatistics& statistics) {
  statistics.accepted[survivor.raw] = 0;
  statistics.score[survivor.raw] = 0;
  statistics.relative_score[survivor.raw] = 0.f;
  --statistics.accepted_count;
}

void rejectByDisplacement(const std::vector<Survivor>& survivors, MotionStatistics& statistics) {
  const int columns = statistics.grid_columns, rows = statistics.grid_rows;
  std::vector<std::vector<Survivor>> cells(static_cast<size_t>(columns) * rows);
  for (const Survivor& survivor : survivors) cells[statistics.cell[survivor.raw]].push_back(survivor);
  std::vector<float> pool;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::vector<Survivor>& cell = cells[row * columns + column];
      if (cell.empty()) continue;
      pool.clear();
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns - 1); ++x) {
          for (const Survivor& other : cells[y * columns + x]) pool.push_back(distance(other.from, other.to));
        }
      }
      const float middle = median(pool);
      for (float& length : pool) length = std::fabs(length - middle);
      const auto tolerance = std::max(kLeastTolerance, static_cast<float>(kSigmas * kMadToSigma * median(pool)));
      for (const Survivor& own : cell) {
        if (std::fabs(distance(own.from, own.to) - middle) > tolerance) reject(own, statistics);
      }
    }
  }
}

void rejectByPairs(const std::vector<Survivor>& survivors, uint64_t seed, MotionStatistics& statistics) {
  const int n = static_cast<int>(survivors.size());
  if (n < 2) return;
  Random random(seed);
  std::vector<float> ratios, pool;
  for (int k = 0; k < n; ++k) {
    pool.clear();
    for (int i = 0; i < kPartners; ++i) {
      const Survivor& partner = survivors[(k + 1 + random.below(n - 1)) % n];
      const float before = distance(partner.from, survivors[k].from), after = distance(partner.to, survivors[k].to);
      if (before > 0) pool.push_back(after / before);
    }
    ratios.push_back(pool.empty() ? -1.f : median(pool));  // all partners at the same place: no evidence, dropped
  }
  pool = ratios;
  const float common = median(pool);
  for (int k = 0; k < n; ++k) {
    if (!(std::fabs(ratios[k] - common) <= kRatioTolerance * common)) reject(survivors[k], statistics);
  }
}

}  // namespace

void rejectInconsistent(DistanceReading reading, uint64_t seed, const Features& reference, const Features& current,
                        const std::vector<Match>& matches, MotionStatistics& statistics) {
  std::vector<Survivor> survivors;
  for (size_t raw = 0; raw < matches.size(); ++raw) {
    if (!statistics.accepted[raw]) continue;
    const Match& match = matches[raw];
    survivors.push_back({raw, reference.keypoints[match.reference].pt, current.keypoints[match.current].pt});
  }
  if (reading == DistanceReading::kDisplacement) {
    rejectByDisplacement(survivors, statistics);
  } else {
    rejectByPairs(survivors, seed, statistics);
  }
}

}  // namespace gms_ransac
