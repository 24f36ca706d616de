// The room gms decides for every raw match whether the motion of its neighbours supports it. A filter reads the matches
// and never reorders them.
//
#include "gms_ransac/motion_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "gms/cell_pairs.h"

namespace gms_ransac {

namespace {

constexpr int kScales = 5;

// Bian 2017.
constexpr int kPaperGrid = 20;
constexpr double kPaperThresholdFactor = 6.0;

// Cells of 6 matches give the best poses where matches are few (doc/measured/stages.md). The threshold leaves
// out matches without any support.
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

// Degrees; nine of ten right matches stay within 15, of the wrong ones a quarter.
constexpr float kMostRotation = 30.f;
constexpr int kRotationBins = 36;
constexpr float kBinDegrees = 360.f / kRotationBins;
constexpr int kOctaves = 32;  ///< more than any pyramid has
constexpr int kMostOctaves = 4;

// Log-odds from which a match is kept: of -1.5 to 0.5 the one with the best poses.
constexpr float kLeastLogOdds = -1.f;
// Logistic regression of "within 3 px of the true epipolar line" on three real sequences
// (doc/inside/motion_statistics.md).
constexpr float kConstant = 1.59f;
constexpr float kPerLogVotes = 0.752f;
constexpr float kPerBit = -0.562f / 32;     ///< of Hamming distance
constexpr float kPerRatio = -0.346f * 4;    ///< distance over second distance
constexpr float kPerDegree = -0.675f / 15;  ///< of rotation
constexpr float kPerOctave = -0.348f;

/// Degrees in [0, 360); negative if an orientation is unknown.
float rotationBetween(const cv::KeyPoint& from, const cv::KeyPoint& to) {
  const float before = wrappedAngle(from.angle), after = wrappedAngle(to.angle);
  if (before < 0 || after < 0) return -1.f;
  const float degrees = after - before;
  return degrees < 0 ? degrees + 360.f : degrees;
}

/// First of the `width` neighbouring bins that hold most together; `votes` is read past `bins` by width - 1.
int fullest(const int* votes, int bins, int width) {
  int best = 0, most = -1;
  for (int bin = 0; bin < bins; ++bin) {
    int sum = 0;
    for (int i = 0; i < width; ++i) sum += votes[bin + i];
    if (sum > most) {
      most = sum;
      best = bin;
    }
  }
  return best;
}

/// Evidence for a match in addition to its neighbours' votes: alike descriptors, and a keypoint that rotates and
/// changes octave as most do. Not part of any paper.
class MatchEvidence {
 public:
  /// Finds the most common rotation and change of octave of the matches. Returns how many matches vote.
  int prepare(const Features& reference, const Features& current, const std::vector<Match>& matches) {
    std::array<int, kRotationBins + 1> rotation_votes = {};
    std::array<int, 2 * kOctaves + 2> octave_votes = {};
    rotation_.resize(matches.size());
    octave_change_.resize(matches.size());
    voting_.resize(matches.size());
    for (size_t i = 0; i < matches.size(); ++i) {
      const cv::KeyPoint& from = reference.keypoints[matches[i].reference];
      const cv::KeyPoint& to = current.keypoints[matches[i].current];
      rotation_[i] = rotationBetween(from, to);
      if (rotation_[i] >= 0) ++rotation_votes[static_cast<size_t>(rotation_[i] / kBinDegrees) % kRotationBins];
      octave_change_[i] =
          static_cast<uint8_t>(std::min(std::max(to.octave - from.octave + kOctaves, 1), 2 * kOctaves - 1));
      ++octave_votes[octave_change_[i]];
    }
    rotation_votes[kRotationBins] = rotation_votes[0];
    const float common_rotation =
        static_cast<float>(fullest(rotation_votes.data(), kRotationBins, 2) + 1) * kBinDegrees;
    const int common_octave_change = fullest(octave_votes.data(), 2 * kOctaves, 3) + 1;

    int count = 0;
    for (size_t i = 0; i < matches.size(); ++i) {
      const float apart = std::fabs(rotation_[i] - common_rotation);
      rotation_[i] = rotation_[i] < 0 ? 0.f : std::min(apart, 360.f - apart);
      octave_change_[i] =
          static_cast<uint8_t>(std::min(std::abs(octave_change_[i] - common_octave_change), kMostOctaves));
      voting_[i] = rotation_[i] <= kMostRotation;
      count += voting_[i];
    }
    return count;
  }

  /// Per match: 1 unless its keypoint rotates otherwise than most.
  const std::vector<uint8_t>& voting() const { return voting_; }

  /// Log-odds that match `i` is right. `votes`: its score over the square root of the mean matches of neighbouring
  /// cells.
  float logOdds(int i, const Match& match, float votes) const {
    const float ratio =
        static_cast<float>(match.distance) / static_cast<float>(std::max<int>(match.second_distance, 1));
    return kConstant + kPerLogVotes * std::log(votes) + kPerBit * static_cast<float>(match.distance) +
           kPerRatio * ratio + kPerDegree * rotation_[i] + kPerOctave * static_cast<float>(octave_change_[i]);
  }

 private:
  std::vector<uint8_t> voting_;
  std::vector<float> rotation_;         ///< degrees away from the common rotation, 0 if unknown
  std::vector<uint8_t> octave_change_;  ///< octaves away from the common change
};

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

  void decide(const CellGrid& right) {
    cells.setRightGrid(right);
    half_members.assign(cells.unassigned() + 1, 0);
    for (const int32_t half : cells.halfCells()) ++half_members[half];
    for (CellPairs& shifted : pairs) shifted.decide(cells, half_members, right, matrix);
  }

  std::array<int, 8> countAccepted() const {
    std::array<int, 8> counts{};
    for (int i = 0; i < cells.size(); ++i) {
      const int half = cells.halfCells()[i], right = cells.rightCells()[i];
      unsigned accepted = 0;
      for (const CellPairs& shifted : pairs) accepted |= shifted.accepted(shifted.cellOfHalf()[half], right);
      for (size_t rotation = 0; rotation < 8; ++rotation)
        counts[rotation] += static_cast<int>(accepted >> rotation & 1);
    }
    return counts;
  }

  int mark(int rotation, MotionStatistics& statistics) {
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

  void weighEvidence(const std::vector<Match>& matches, double alpha, MotionStatistics& statistics) const {
    statistics.accepted_count = 0;
    statistics.log_odds.assign(matches.size(), 0.f);
    for (size_t i = 0; i < matches.size(); ++i) {
      if (!statistics.accepted[i]) continue;
      const float votes = statistics.relative_score[i] * static_cast<float>(alpha);
      statistics.log_odds[i] = evidence.logOdds(static_cast<int>(i), matches[i], votes);
      const bool likely = statistics.log_odds[i] >= kLeastLogOdds;
      statistics.accepted[i] = likely;
      statistics.score[i] = likely ? statistics.score[i] : 0;
      statistics.relative_score[i] = likely ? statistics.relative_score[i] : 0.f;
      statistics.accepted_count += likely;
    }
  }
};

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
