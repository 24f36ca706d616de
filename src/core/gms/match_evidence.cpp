#include "gms/match_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace gms_ransac {

namespace {

constexpr float kMostRotation =
    30.f;  ///< degrees; nine of ten right matches stay within 15, of the wrong ones a quarter
constexpr int kRotationBins = 36;
constexpr float kBinDegrees = 360.f / kRotationBins;
constexpr int kOctaves = 32;  ///< more than any pyramid has
constexpr int kMostOctaves = 4;

// Logistic regression of "within 3 px of the true epipolar line" on three real sequences (doc/motion_statistics.md).
constexpr float kConstant = 1.59f;
constexpr float kPerLogVotes = 0.752f;
constexpr float kPerBit = -0.562f / 32;     ///< of Hamming distance
constexpr float kPerRatio = -0.346f * 4;    ///< distance over second distance
constexpr float kPerDegree = -0.675f / 15;  ///< of rotation
constexpr float kPerOctave = -0.348f;

/// Degrees in [0, 360); negative if an orientation is unknown.
float rotationBetween(const cv::KeyPoint& from, const cv::KeyPoint& to) {
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
  const float common_rotation = static_cast<float>(fullest(rotation_votes.data(), kRotationBins, 2) + 1) * kBinDegrees;
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

float MatchEvidence::logOdds(int i, const Match& match, float votes) const {
  const float ratio = static_cast<float>(match.distance) / static_cast<float>(std::max<int>(match.second_distance, 1));
  return kConstant + kPerLogVotes * std::log(votes) + kPerBit * static_cast<float>(match.distance) + kPerRatio * ratio +
         kPerDegree * rotation_[i] + kPerOctave * static_cast<float>(octave_change_[i]);
}

}  // namespace gms_ransac
