#include "matching/repetition.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "support/order_statistics.h"

namespace gms_ransac {

namespace {

/// Inliers that are looked at, and other places of each.
constexpr size_t kSamples = 100, kPlaces = 4;
/// With fewer whose second place is as near as most first ones, nothing is looked for.
constexpr double kLeastAmbiguous = 0.1;
/// Bits in which another place differs at most. The posts along a road differ by more.
constexpr int kAlike = 36;
/// Share of the samples that show a pattern. Recordings of streets, rooms and boards of tags stay below a quarter.
constexpr double kRepeats = 0.25;
/// The samples are looked at in rounds, each all over the view. The search ends after a round if hardly any of enough
/// show a pattern. Where a quarter of all do, two of the first 25 do in 99 of 100 cases.
constexpr size_t kRounds = 4, kFewestLooked = kSamples / kRounds;
constexpr double kHardlyAny = 0.08;
/// So many neighbours within a radius, in mean distances of the samples, that take the same step.
constexpr int kNeighbours = 2;
constexpr float kRadius = 1.5f;
/// Steps are the same up to a part of their length, as a view from aside changes them, and some pixels.
constexpr float kSameShare = 0.15f, kSamePixels = 4;

bool same(const cv::Point2f& a, const cv::Point2f& b) {
  const float most = kSamePixels + kSameShare * std::sqrt(a.dot(a));
  const cv::Point2f there = a - b, back = a + b;
  return std::min(there.dot(there), back.dot(back)) < most * most;
}

}  // namespace

std::optional<double> Repetition::period(const Features& reference, const Features& current,
                                         const std::vector<Match>& matches, const std::vector<uint8_t>& inlier) {
  inliers_.clear();
  distances_.clear();
  for (size_t row = 0; row < matches.size(); ++row) {
    if (inlier[row] == 0) continue;
    inliers_.push_back(row);
    distances_.push_back(matches[row].distance);
  }
  if (inliers_.empty()) return std::nullopt;
  const auto usual = static_cast<int>(nthSmallest(distances_, distances_.size() * 3 / 4));
  const auto ambiguous = std::count_if(inliers_.begin(), inliers_.end(),
                                       [&](size_t row) { return matches[row].second_distance <= usual; });
  if (static_cast<double>(ambiguous) < kLeastAmbiguous * static_cast<double>(inliers_.size())) return std::nullopt;

  const int alike = std::min(usual, kAlike);
  const auto count = static_cast<size_t>(current.size());
  x_.resize(count);
  y_.resize(count);
  near_.resize(count);
  for (size_t i = 0; i < count; ++i) {
    x_[i] = current.keypoints[i].pt.x;
    y_[i] = current.keypoints[i].pt.y;
  }
  index_.resize(count + kRowsReadPast);
  std::iota(index_.begin(), index_.end(), 0);
  const size_t samples = std::min(kSamples, inliers_.size());
  samples_.resize(samples);
  const double enough = kRepeats * static_cast<double>(samples);
  size_t looked = 0, found = 0;
  for (size_t round = 0; round < kRounds; ++round) {
    for (size_t k = round; k < samples; k += kRounds) {
      const Match& match = matches[inliers_[k * inliers_.size() / samples]];
      findElsewhere(reference.descriptors.row(match.reference), current.keypoints[static_cast<size_t>(match.current)],
                    current, alike, samples_[k]);
      found += !samples_[k].elsewhere.empty();
      ++looked;
      if (static_cast<double>(found + samples - looked) < enough) return std::nullopt;
    }
    const bool hardly_any = static_cast<double>(found) < kHardlyAny * static_cast<double>(looked);
    if (hardly_any && looked >= kFewestLooked) return std::nullopt;
  }
  const float spacing = std::sqrt(static_cast<float>(current.image_size.area()) / static_cast<float>(samples));
  periods_.clear();
  for (const Sample& sample : samples_) {
    if (const auto step = sharedStep(sample, kRadius * spacing)) periods_.push_back(*step);
  }
  if (static_cast<double>(periods_.size()) < enough) return std::nullopt;
  return nthSmallest(periods_, periods_.size() / 2);
}

void Repetition::findElsewhere(const uint8_t* query, const cv::KeyPoint& place, const Features& current, int most,
                               Sample& sample) {
  sample.point = place.pt;
  sample.elsewhere.clear();
  const auto nextNear = [&](int begin, int end) {
    const void* found = std::memchr(near_.data() + begin, 1, static_cast<size_t>(end - begin));
    return found == nullptr ? end : static_cast<int>(static_cast<const uint8_t*>(found) - near_.data());
  };
  runs_.assign(1, {0, current.size()});
  // Corners of one patch are one place: its own first, then each that was found.
  for (cv::Point2f taken = place.pt; sample.elsewhere.size() < kPlaces;) {
    markNear(taken, place.size * place.size);
    const size_t before = runs_.size();
    for (size_t r = 0; r < before; ++r) {
      const RowRun run = runs_[r];
      int first = run.first;
      for (int i = first; (i = nextNear(i, run.last)) < run.last; ++i) {
        if (first < i) runs_.push_back({first, i});
        first = i + 1;
      }
      runs_[r] = {first, run.last};
    }
    runs_.erase(std::remove_if(runs_.begin(), runs_.end(), [](const RowRun& run) { return run.first >= run.last; }),
                runs_.end());
    const NearestTwo nearest = kernel_.searchRuns(query, current.descriptors.row(0), index_.data(), runs_.data(),
                                                  static_cast<int>(runs_.size()));
    if (nearest.index < 0 || nearest.distance > most) return;
    taken = current.keypoints[static_cast<size_t>(nearest.index)].pt;
    sample.elsewhere.push_back(taken - place.pt);
  }
}

void Repetition::markNear(const cv::Point2f& point, float most) {
  // Copies, because a byte that is written may be part of anything.
  const float *x = x_.data(), *y = y_.data(), at_x = point.x, at_y = point.y;
  uint8_t* near = near_.data();
  const size_t count = near_.size();
  for (size_t i = 0; i < count; ++i) {
    const float across = x[i] - at_x, along = y[i] - at_y;
    near[i] = static_cast<uint8_t>(across * across + along * along < most);
  }
}

std::optional<float> Repetition::sharedStep(const Sample& sample, float radius) const {
  for (const cv::Point2f& step : sample.elsewhere) {
    const auto takes_it = [&](const Sample& other) {
      const cv::Point2f apart = other.point - sample.point;
      return &other != &sample && apart.dot(apart) < radius * radius &&
             std::any_of(other.elsewhere.begin(), other.elsewhere.end(),
                         [&](const cv::Point2f& its) { return same(step, its); });
    };
    if (std::count_if(samples_.begin(), samples_.end(), takes_it) >= kNeighbours) return std::sqrt(step.dot(step));
  }
  return std::nullopt;
}

}  // namespace gms_ransac
