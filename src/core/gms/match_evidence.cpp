#include "gms/match_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace gms_ransac {

namespace {

constexpr float kMostTurn = 30.f;  ///< degrees; nine of ten right matches stay within 15, of the wrong ones a quarter
constexpr int kTurnBins = 36;
constexpr float kBinDegrees = 360.f / kTurnBins;
constexpr int kOctaves = 32;  ///< more than any pyramid has
constexpr int kMostOctaves = 4;

// Logistic regression of "within 3 px of the true epipolar line" with cv::ORB at 1000, 2000 and 4000 features, each of
// kitti_06 (gaps 1, 5, 10), tum_fr1_desk (1, 4) and tum_fr1_rpy (1, 5) with equal weight, in cells of two matches.
// Fitted without a set, the numbers serve it equally well (doc/motion_statistics.md).
constexpr float kConstant = 1.59f;
constexpr float kPerLogVotes = 0.752f;
constexpr float kPerBit = -0.562f / 32;     ///< of Hamming distance
constexpr float kPerRatio = -0.346f * 4;    ///< distance over second distance
constexpr float kPerDegree = -0.675f / 15;  ///< of turn
constexpr float kPerOctave = -0.348f;

/// Degrees in [0, 360); negative if an orientation is unknown.
float turnOf(const cv::KeyPoint& from, const cv::KeyPoint& to) {
  if (from.angle < 0 || to.angle < 0) return -1.f;
  const float degrees = to.angle - from.angle;
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

}  // namespace

int MatchEvidence::prepare(const Features& reference, const Features& current, const std::vector<Match>& matches) {
  std::array<int, kTurnBins + 1> turn_votes = {};
  std::array<int, 2 * kOctaves + 2> octave_votes = {};
  turn_.resize(matches.size());
  octave_change_.resize(matches.size());
  voting_.resize(matches.size());
  for (size_t i = 0; i < matches.size(); ++i) {
    const cv::KeyPoint& from = reference.keypoints[matches[i].reference];
    const cv::KeyPoint& to = current.keypoints[matches[i].current];
    turn_[i] = turnOf(from, to);
    if (turn_[i] >= 0) ++turn_votes[static_cast<size_t>(turn_[i] / kBinDegrees) % kTurnBins];
    octave_change_[i] =
        static_cast<uint8_t>(std::min(std::max(to.octave - from.octave + kOctaves, 1), 2 * kOctaves - 1));
    ++octave_votes[octave_change_[i]];
  }
  turn_votes[kTurnBins] = turn_votes[0];
  const float common_turn = static_cast<float>(fullest(turn_votes.data(), kTurnBins, 2) + 1) * kBinDegrees;
  const int common_octave_change = fullest(octave_votes.data(), 2 * kOctaves, 3) + 1;

  int count = 0;
  for (size_t i = 0; i < matches.size(); ++i) {
    const float apart = std::fabs(turn_[i] - common_turn);
    turn_[i] = turn_[i] < 0 ? 0.f : std::min(apart, 360.f - apart);
    octave_change_[i] =
        static_cast<uint8_t>(std::min(std::abs(octave_change_[i] - common_octave_change), kMostOctaves));
    voting_[i] = turn_[i] <= kMostTurn;
    count += voting_[i];
  }
  return count;
}

float MatchEvidence::logOdds(int i, const Match& match, float votes) const {
  const float ratio = static_cast<float>(match.distance) / static_cast<float>(std::max<int>(match.second_distance, 1));
  return kConstant + kPerLogVotes * std::log(votes) + kPerBit * static_cast<float>(match.distance) + kPerRatio * ratio +
         kPerDegree * turn_[i] + kPerOctave * static_cast<float>(octave_change_[i]);
}

}  // namespace gms_ransac
