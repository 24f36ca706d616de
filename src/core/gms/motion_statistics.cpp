#include "gms_ransac/motion_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gms/cell_pairs.h"
#include "gms/match_cells.h"
#include "gms/match_evidence.h"

namespace gms_ransac {

namespace {

constexpr int kScales = 5;

// Bian 2017.
constexpr int kPaperGrid = 20;
constexpr double kPaperThresholdFactor = 6.0;

// Cells of 6 matches give the best poses where matches are few (doc/motion_statistics.md). The threshold only spares
// what nobody votes for.
constexpr double kMatchesPerCell = 6.0;
constexpr double kEvidenceThresholdFactor = 1.0;
constexpr double kMostCells = 400;  ///< as in the paper; with more, the vote matrix leaves the cache
constexpr int kFewestOnSide = 4, kMostOnSide = 100;

int automaticSide(double cells) {
  return std::min(std::max(static_cast<int>(std::lround(cells)), kFewestOnSide), kMostOnSide);
}

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
  if (rule.five_cells) rule.alpha *= std::sqrt(5.0 / 9.0);
  return rule;
}

}  // namespace

MotionStatisticsOptions withDefaults(MotionStatisticsOptions given, Criterion own) {
  given.criterion = given.criterion.value_or(own);
  const bool weighs = given.criterion == Criterion::kEvidence;
  given.threshold_factor = given.threshold_factor.value_or(weighs ? kEvidenceThresholdFactor : kPaperThresholdFactor);
  if (!weighs && !given.grid_columns && !given.grid_rows) given.grid_columns = given.grid_rows = kPaperGrid;
  return given;
}

CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches) {
  const double width = std::max(image.width, 1), height = std::max(image.height, 1);
  const double cells = std::min(std::max(matches / kMatchesPerCell, 1.0), kMostCells);
  double side = std::sqrt(width * height / cells);  // of a cell, pixels
  if (options.grid_rows) side = height / *options.grid_rows;
  if (options.grid_columns) side = width / *options.grid_columns;
  return {options.grid_columns.value_or(automaticSide(width / side)),
          options.grid_rows.value_or(automaticSide(height / side))};
}

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

void MotionStatisticsFilter::Workspace::decide(const CellGrid& right) {
  cells.setRightGrid(right);
  half_members.assign(cells.unassigned() + 1, 0);
  for (const int32_t half : cells.halfCells()) ++half_members[half];
  for (CellPairs& shifted : pairs) shifted.decide(cells, half_members, right, matrix);
}

std::array<int, 8> MotionStatisticsFilter::Workspace::countAccepted() const {
  std::array<int, 8> counts{};
  for (int i = 0; i < cells.size(); ++i) {
    const int half = cells.halfCells()[i], right = cells.rightCells()[i];
    unsigned accepted = 0;
    for (const CellPairs& shifted : pairs) accepted |= shifted.accepted(shifted.cellOfHalf()[half], right);
    for (size_t rotation = 0; rotation < 8; ++rotation) counts[rotation] += static_cast<int>(accepted >> rotation & 1);
  }
  return counts;
}

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
