#include "gms_ransac/motion_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gms/cell_pairs.h"
#include "gms/match_cells.h"
#include "gms/match_evidence.h"
#include "gms/presets.h"
#include "validation.h"

namespace gms_ransac {

namespace {

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
  rule.drop_first = options.border == GridBorder::kOriginal;
  rule.alpha = *options.threshold_factor;
  if (rule.five_cells && options.five_cell_factor == FiveCellFactor::kScaled) rule.alpha *= std::sqrt(5.0 / 9.0);
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

void MotionStatisticsOptions::validate() const { requireInRanges(*this); }

struct MotionStatisticsFilter::Workspace {
  CellGrid left;
  MatchCells cells;
  VoteMatrix matrix;
  CellPairs pairs[kShifts];
  std::vector<int32_t> half_members;
  MatchEvidence evidence;

  void decide(const CellGrid& right);
  std::array<int, 8> countAccepted() const;
  int mark(int rotation, MotionStatistics& statistics);
  void weighEvidence(const std::vector<Match>& matches, double alpha, MotionStatistics& statistics) const;
};

/// Decides on the cell pairs of all four grids, for this right grid and every rotation.
void MotionStatisticsFilter::Workspace::decide(const CellGrid& right) {
  cells.setRightGrid(right);
  half_members.assign(cells.unassigned() + 1, 0);
  for (const int32_t half : cells.halfCells()) ++half_members[half];
  for (CellPairs& shifted : pairs) shifted.decide(cells, half_members, right, matrix);
}

/// How many matches each rotation accepts.
std::array<int, 8> MotionStatisticsFilter::Workspace::countAccepted() const {
  BitCounts counts;
  for (int i = 0; i < cells.size(); ++i) {
    const int half = cells.halfCells()[i], right = cells.rightCells()[i];
    unsigned accepted = 0;
    for (const CellPairs& shifted : pairs) accepted |= shifted.accepted(shifted.cellOfHalf()[half], right);
    counts.add(accepted);
  }
  return counts.counts();
}

/// Writes the columns of one run; returns how many matches it accepts.
int MotionStatisticsFilter::Workspace::mark(int rotation, MotionStatistics& statistics) {
  for (CellPairs& shifted : pairs) shifted.choose(rotation);
  int accepted = 0;
  for (int i = 0; i < cells.size(); ++i) {
    const int half = cells.halfCells()[i], right = cells.rightCells()[i];
    int score = 0;
    float relative_score = 0;
    for (const CellPairs& shifted : pairs) {
      const CellPairs::PairScore& pair = shifted.pairScore(shifted.cellOfHalf()[half]);
      const bool better = pair.right == right && pair.score > score;
      score = better ? pair.score : score;
      relative_score = better ? pair.relative_score : relative_score;
    }
    statistics.accepted[i] = score > 0;
    statistics.score[i] = score;
    statistics.relative_score[i] = relative_score;
    accepted += score > 0;
  }
  return accepted;
}

/// Keeps of the accepted matches those that are likely to be right.
void MotionStatisticsFilter::Workspace::weighEvidence(const std::vector<Match>& matches, double alpha,
                                                      MotionStatistics& statistics) const {
  statistics.accepted_count = 0;
  statistics.log_odds.assign(matches.size(), 0.f);
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!statistics.accepted[i]) continue;
    const float votes = statistics.relative_score[i] * static_cast<float>(alpha);
    statistics.log_odds[i] = evidence.logOdds(static_cast<int>(i), matches[i], votes);
    const bool likely = statistics.log_odds[i] >= MatchEvidence::kLeastLogOdds;
    statistics.accepted[i] = likely;
    statistics.score[i] = likely ? statistics.score[i] : 0;
    statistics.relative_score[i] = likely ? statistics.relative_score[i] : 0.f;
    statistics.accepted_count += likely;
  }
}

MotionStatisticsFilter::MotionStatisticsFilter(const MotionStatisticsOptions& options)
    : options_(withDefaults(options)), workspace_(std::make_unique<Workspace>()) {
  options_.validate();
}
MotionStatisticsFilter::~MotionStatisticsFilter() = default;
MotionStatisticsFilter::MotionStatisticsFilter(MotionStatisticsFilter&&) noexcept = default;
MotionStatisticsFilter& MotionStatisticsFilter::operator=(MotionStatisticsFilter&&) noexcept = default;

void MotionStatisticsFilter::compute(const Features& reference, const Features& current,
                                     const std::vector<Match>& matches, MotionStatistics& statistics) {
  Workspace& work = *workspace_;
  int voters = static_cast<int>(matches.size());
  if (options_.criterion == Criterion::kEvidence) voters = work.evidence.prepare(reference, current, matches);
  work.left = chooseGrid(options_, reference.image_size, voters);
  statistics.grid_columns = work.left.columns;
  statistics.grid_rows = work.left.rows;
  statistics.accepted_count = statistics.rotation = statistics.scale = 0;
  statistics.accepted.assign(matches.size(), 0);
  statistics.score.assign(matches.size(), 0);
  statistics.relative_score.assign(matches.size(), 0.f);
  statistics.log_odds.clear();
  statistics.cell.resize(matches.size());
  work.cells.setMatches(reference, current, matches, work.evidence.voting(), work.left);
  work.cells.leftCells(statistics.cell);

  const VotingRule rule = votingRule(options_);
  for (int shift = 0; shift < kShifts; ++shift) work.pairs[shift].setLeftGrid(work.left, shift, rule);
  const int scales = options_.scale ? kScales : 1;
  for (int scale = 0; scale < scales; ++scale) {
    work.decide(
        {scaledSide(work.left.columns, scale, options_.border), scaledSide(work.left.rows, scale, options_.border)});
    int rotation = 0;
    if (scales * rule.rotations() > 1) {
      const std::array<int, 8> accepted = work.countAccepted();
      const auto most = std::max_element(accepted.begin(), accepted.end());  // the first of equals
      if (*most <= statistics.accepted_count) continue;
      rotation = static_cast<int>(most - accepted.begin());
    }
    statistics.accepted_count = work.mark(rotation, statistics);
    statistics.rotation = rotation * rule.ringStep();
    statistics.scale = scale;
  }
  if (options_.criterion == Criterion::kEvidence) work.weighEvidence(matches, rule.alpha, statistics);
}

}  // namespace gms_ransac
