#include "gms_ransac/motion_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "motion_statistics/grid_votes.h"
#include "motion_statistics/half_cell_order.h"
#include "validation.h"

namespace gms_ransac {

namespace {

constexpr int kShifts = 4;  ///< none, half a cell in x, in y, in both
constexpr int kScales = 5;

/// Side of the right grid for one side of the left one.
int scaledSide(int side, int scale, GridBorder border) {
  const double ratios[kScales] = {1.0, 0.5, 1.0 / std::sqrt(2.0), std::sqrt(2.0), 2.0};
  const double scaled = side * ratios[scale];
  return std::max(1, static_cast<int>(border == GridBorder::kOriginal ? scaled : std::rint(scaled)));
}

VotingRule votingRule(const MotionStatisticsOptions& options) {
  VotingRule rule;
  rule.five_cells = options.neighborhood == GridNeighborhood::kFive;
  rule.rotation = options.rotation;
  rule.alpha = options.threshold_factor;
  if (rule.five_cells && options.alpha_mode == AlphaMode::kScaled) rule.alpha *= std::sqrt(5.0 / 9.0);
  return rule;
}

/// Number of set bits at each of eight positions over many bytes, eight counters in one word.
class BitCounts {
 public:
  void add(unsigned bits) {
    word_ += kSpread[bits & 15] | static_cast<uint64_t>(kSpread[bits >> 4]) << 32;
    if (++added_ == 255) flush();
  }
  const std::array<int, 8>& counts() {
    flush();
    return counts_;
  }

 private:
  static constexpr uint32_t kSpread[16] = {0x00000000, 0x00000001, 0x00000100, 0x00000101, 0x00010000, 0x00010001,
                                           0x00010100, 0x00010101, 0x01000000, 0x01000001, 0x01000100, 0x01000101,
                                           0x01010000, 0x01010001, 0x01010100, 0x01010101};
  void flush() {
    for (int bit = 0; bit < 8; ++bit) counts_[bit] += static_cast<int>(word_ >> (8 * bit) & 255);
    word_ = 0;
    added_ = 0;
  }
  std::array<int, 8> counts_ = {};
  uint64_t word_ = 0;
  int added_ = 0;
};

}  // namespace

void MotionStatisticsOptions::validate() const {
  if (grid_columns != 0) requireInRange("grid_columns", grid_columns, 2, 100);
  if (grid_rows != 0) requireInRange("grid_rows", grid_rows, 2, 100);
  requireInRange("threshold_factor", threshold_factor, 0.01, 100.0);
}

struct MotionStatisticsFilter::Workspace {
  CellGrid left;
  HalfCellOrder order;
  GridVotes votes[kShifts];
  std::vector<uint8_t> favourite;  ///< per place of the order, bit s: the match is in its cell pair of shift s
  int best_accepted = 0;

  int leftCell(int match, int shift) const {
    return left.index((order.halfColumn(match) + (shift & 1)) >> 1, (order.halfRow(match) + (shift >> 1)) >> 1);
  }
  int countMatches(const CellGrid& right, bool drop_first);
  std::array<int, 8> countAccepted() const;
  void mark(int rotation, MotionStatistics& statistics) const;
};

/// Counts all four grids; returns how many matches go to the favourite cell in one of them, a bound on what any
/// rotation can accept.
int MotionStatisticsFilter::Workspace::countMatches(const CellGrid& right, bool drop_first) {
  order.sort(right);
  for (int shift = 0; shift < kShifts; ++shift) {
    votes[shift].setGrids(left, right);
    votes[shift].count(order, shift & 1, shift >> 1, drop_first);
  }
  int bound = 0;
  favourite.resize(order.size());
  for (int place = 0; place < order.size(); ++place) {
    unsigned bits = 0;
    for (int shift = 0; shift < kShifts; ++shift) {
      const bool same = votes[shift].best(leftCell(order.sorted()[place], shift)) == order.rightCells()[place];
      bits |= static_cast<unsigned>(same) << shift;
    }
    favourite[place] = static_cast<uint8_t>(bits);
    bound += bits != 0;
  }
  return bound;
}

std::array<int, 8> MotionStatisticsFilter::Workspace::countAccepted() const {
  BitCounts counts;
  for (int place = 0; place < order.size(); ++place) {
    unsigned accepted = 0;
    for (int shift = 0; shift < kShifts; ++shift) {
      if (!(favourite[place] >> shift & 1)) continue;
      accepted |= votes[shift].accepted(leftCell(order.sorted()[place], shift));
    }
    counts.add(accepted);
  }
  return counts.counts();
}

void MotionStatisticsFilter::Workspace::mark(int rotation, MotionStatistics& statistics) const {
  std::fill(statistics.accepted.begin(), statistics.accepted.end(), 0);
  std::fill(statistics.score.begin(), statistics.score.end(), 0);
  std::fill(statistics.support.begin(), statistics.support.end(), 0.f);
  for (int place = 0; place < order.size(); ++place) {
    const int match = order.sorted()[place];
    int score = 0;
    double threshold = 1.0;
    for (int shift = 0; shift < kShifts; ++shift) {
      const int cell = leftCell(match, shift);
      if (!(favourite[place] >> shift & 1) || !(votes[shift].accepted(cell) >> rotation & 1)) continue;
      if (votes[shift].score(cell, rotation) <= score) continue;
      score = votes[shift].score(cell, rotation);
      threshold = votes[shift].threshold(cell, rotation);
    }
    statistics.accepted[match] = score > 0;
    statistics.score[match] = score;
    statistics.support[match] = static_cast<float>(score / threshold);
  }
}

MotionStatisticsFilter::MotionStatisticsFilter(const MotionStatisticsOptions& options)
    : options_(options), workspace_(std::make_unique<Workspace>()) {
  options_.validate();
}
MotionStatisticsFilter::~MotionStatisticsFilter() = default;
MotionStatisticsFilter::MotionStatisticsFilter(MotionStatisticsFilter&&) noexcept = default;
MotionStatisticsFilter& MotionStatisticsFilter::operator=(MotionStatisticsFilter&&) noexcept = default;

void MotionStatisticsFilter::compute(const Features& reference, const Features& current,
                                     const std::vector<Match>& matches, MotionStatistics& statistics) {
  Workspace& work = *workspace_;
  work.left = {options_.grid_columns ? options_.grid_columns : 20, options_.grid_rows ? options_.grid_rows : 20};
  statistics.grid_columns = work.left.columns;
  statistics.grid_rows = work.left.rows;
  statistics.accepted_count = statistics.rotation = statistics.scale = 0;
  statistics.accepted.assign(matches.size(), 0);
  statistics.score.assign(matches.size(), 0);
  statistics.support.assign(matches.size(), 0.f);
  statistics.cell.resize(matches.size());
  work.order.setMatches(reference, current, matches, work.left);
  for (size_t i = 0; i < matches.size(); ++i) {
    const int match = static_cast<int>(i);
    statistics.cell[i] = (work.order.halfRow(match) >> 1) * work.left.columns + (work.order.halfColumn(match) >> 1);
  }

  const VotingRule rule = votingRule(options_);
  for (int scale = 0; scale < (options_.scale ? kScales : 1); ++scale) {
    const CellGrid right = {scaledSide(work.left.columns, scale, options_.border),
                            scaledSide(work.left.rows, scale, options_.border)};
    const int bound = work.countMatches(right, options_.border == GridBorder::kOriginal);
    if (bound <= statistics.accepted_count) continue;
    for (GridVotes& votes : work.votes) votes.decide(rule);
    const std::array<int, 8> accepted = work.countAccepted();
    const auto most = std::max_element(accepted.begin(), accepted.end());  // the first of equals
    if (*most <= statistics.accepted_count) continue;
    statistics.accepted_count = *most;
    statistics.rotation = static_cast<int>(most - accepted.begin()) * rule.ringStep();
    statistics.scale = scale;
    work.mark(static_cast<int>(most - accepted.begin()), statistics);
  }
}

}  // namespace gms_ransac
