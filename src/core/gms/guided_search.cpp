#include "gms_ransac/guided_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <stdexcept>

#include "gms/motion_predictor.h"
#include "matching/guided_windows.h"
#include "worker_pool.h"

namespace gms_ransac {

namespace {

/// The first matches, which are searched in full, are those of the strongest keypoints in every part of the image. Of
/// so many parts, or of one for so many keypoints: with fewer the windows grow, with more the first matches cost more.
constexpr int kSeedsAPart = 4;
constexpr int kFewestParts = 100;
constexpr int kKeypointsAPart = 50;
/// With fewer keypoints for each of the first all are searched in full: a guided search takes as long (0.16 ms of 0.17
/// with 800 keypoints of tum_fr3_cabinet).
constexpr int kLeastKeypointsASeed = 3;

/// Bits above the usual distance of the second nearest up to which the nearest in a window is taken. Of 0, 15 and 25
/// the first at which no set has fewer right matches than with a full search (tum_fr1_desk: 1071, 1152 and 1173 of
/// 1173).
constexpr int kBitsAboveSecond = 25;
/// Share of the image above which a window is not worth it.
constexpr float kLargestWindow = 0.1f;
constexpr int kFeaturesAShare = 256;  ///< that one thread looks for in a row: 0.1 ms

// A prediction from outside is believed if so many times, and standard deviations, more of the first matches lie where
// it says than would by chance. Wrong matches crowd where keypoints do.
constexpr double kTimesChance = 3, kSigmasAboveChance = 5;
// What it says is out of view is not searched at all, unless more than this share of the first matches there is
// accepted, which of unrelated images it is at most (doc/guided_search.md).
constexpr double kMostOutOfView = 0.1;

constexpr int kNoMatch = -1;

/// Keeps the strongest of a part in order, the first of equals first.
void insertByStrength(const std::vector<cv::KeyPoint>& keypoints, int i, int* strongest) {
  const auto response = [&](int k) { return keypoints[static_cast<size_t>(k)].response; };
  int rank = kSeedsAPart;
  while (rank > 0 && (strongest[rank - 1] == kNoMatch || response(strongest[rank - 1]) < response(i))) --rank;
  if (rank == kSeedsAPart) return;
  std::copy_backward(strongest + rank, strongest + kSeedsAPart - 1, strongest + kSeedsAPart);
  strongest[rank] = i;
}

/// Whether no part of the window is in the image.
bool outOfView(const CellMotion& motion, const cv::Point2f& point, const cv::Size& image) {
  const cv::Point2f there = motion.predict(point);
  return there.x + motion.reach.x < 0 || there.y + motion.reach.y < 0 ||
         there.x - motion.reach.x > static_cast<float>(image.width) ||
         there.y - motion.reach.y > static_cast<float>(image.height);
}

/// In a window there are few to be second; a full search would mostly have found one at the usual distance.
uint16_t secondDistance(const NearestTwo& nearest, int usual) {
  return std::max(nearest.distance, std::min(nearest.second_distance, static_cast<uint16_t>(usual)));
}

MotionStatisticsOptions seedStatistics(MotionStatisticsOptions options) {
  options.criterion = Criterion::kEvidence;
  options.threshold_factor.reset();
  options.grid_columns.reset();
  options.grid_rows.reset();
  return options;
}

}  // namespace

struct GuidedSearch::Workspace {
  Workspace(const HammingMatcherOptions& options, const MotionStatisticsOptions& statistics_options)
      : kernel(hammingKernel(options.simd)),
        matcher(options),
        gms(seedStatistics(statistics_options)),
        seats(options.threads),
        pool(WorkerPool::shared(seats - 1)) {}

  const HammingKernel& kernel;
  HammingMatcher matcher;
  MotionStatisticsFilter gms;
  MotionPredictor predictor;
  GuidedWindows windows;
  int seats;
  std::shared_ptr<WorkerPool> pool;

  std::vector<int> strongest;  ///< kSeedsAPart of each part, the strongest first
  std::vector<int> chosen;     ///< reference features to be compared with all
  std::vector<uint8_t> left;   ///< of each reference feature, whether it is yet to be compared with all
  Features seeds;
  DescriptorSet rows;
  MotionStatistics statistics;
  std::vector<Match> found, matches;  ///< of `chosen`; of every reference feature

  bool chooseSeeds(const Features& reference);
  void takeSeeds(const Features& reference);
  /// Compares the chosen ones with all.
  void searchAll(const DescriptorSet& reference, const DescriptorSet& current);
  int usualSecondDistance() const;
  /// Whether the seeds' matches lie where the prediction says.
  bool confirm(const MotionPrediction& prior, const Features& current) const;
  /// Whether what it says is out of view has no matches but by chance.
  bool nothingOutOfView(const MotionPrediction& prior, const cv::Size& image) const;
  void searchWindows(const Features& reference, const Features& current, const MotionPrediction& prediction,
                     const MotionPrediction* prior);
};

/// False where the seeds would be most of the keypoints.
bool GuidedSearch::Workspace::chooseSeeds(const Features& reference) {
  const int wanted = std::max(kFewestParts, reference.size() / kKeypointsAPart);
  if (reference.size() < wanted * kSeedsAPart * kLeastKeypointsASeed) return false;
  const auto width = static_cast<float>(reference.image_size.width);
  const auto height = static_cast<float>(reference.image_size.height);
  const float side = std::sqrt(width * height / static_cast<float>(wanted));
  const int columns = std::max(static_cast<int>(std::lround(width / side)), 1);
  const int rows = std::max(static_cast<int>(std::lround(height / side)), 1);
  const auto part = [](float position, float length, int count) {
    const float place = position * static_cast<float>(count) / length;
    return static_cast<int>(std::min(std::max(place, 0.f), static_cast<float>(count - 1)));
  };
  strongest.assign(static_cast<size_t>(columns) * rows * kSeedsAPart, kNoMatch);
  for (int i = 0; i < reference.size(); ++i) {
    const cv::Point2f& point = reference.keypoints[static_cast<size_t>(i)].pt;
    const int place = part(point.y, height, rows) * columns + part(point.x, width, columns);
    insertByStrength(reference.keypoints, i, &strongest[static_cast<size_t>(place) * kSeedsAPart]);
  }
  chosen.clear();
  std::copy_if(strongest.begin(), strongest.end(), std::back_inserter(chosen), [](int i) { return i != kNoMatch; });
  return true;
}

void GuidedSearch::Workspace::takeSeeds(const Features& reference) {
  seeds.image_size = reference.image_size;
  seeds.scale_factor = reference.scale_factor;
  seeds.keypoints.clear();
  for (const int i : chosen) seeds.keypoints.push_back(reference.keypoints[static_cast<size_t>(i)]);
}

void GuidedSearch::Workspace::searchAll(const DescriptorSet& reference, const DescriptorSet& current) {
  rows.resize(static_cast<int>(chosen.size()));
  for (size_t k = 0; k < chosen.size(); ++k) {
    std::memcpy(rows.row(static_cast<int>(k)), reference.row(chosen[k]), kDescriptorBytes);
  }
  matcher.match(rows, current, found);
  for (const Match& match : found) {
    const int i = chosen[static_cast<size_t>(match.reference)];
    matches[static_cast<size_t>(i)] = {i, match.current, match.distance, match.second_distance};
  }
}

/// The median of those found.
int GuidedSearch::Workspace::usualSecondDistance() const {
  std::array<int, kNoDistance + 1> counts = {};
  for (const Match& match : found) ++counts[match.second_distance];
  int distance = 0, below = 0;
  while ((below += counts[static_cast<size_t>(distance)]) <= static_cast<int>(found.size()) / 2) ++distance;
  return distance;
}

bool GuidedSearch::Workspace::confirm(const MotionPrediction& prior, const Features& current) const {
  const auto area = static_cast<double>(current.image_size.area());
  double inside = 0, chance = 0;
  for (const Match& match : found) {
    const cv::Point2f& from = seeds.keypoints[static_cast<size_t>(match.reference)].pt;
    const CellMotion* motion = prior.at(from, seeds.image_size);
    if (!motion || !motion->known) continue;
    const cv::Point2f apart = current.keypoints[static_cast<size_t>(match.current)].pt - motion->predict(from);
    chance += 4 * motion->reach.x * motion->reach.y / area;
    inside += std::abs(apart.x) <= motion->reach.x && std::abs(apart.y) <= motion->reach.y;
  }
  return inside > kTimesChance * chance && inside > chance + kSigmasAboveChance * std::sqrt(std::max(chance, 1.));
}

bool GuidedSearch::Workspace::nothingOutOfView(const MotionPrediction& prior, const cv::Size& image) const {
  int out = 0, accepted = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    const cv::Point2f& point = seeds.keypoints[static_cast<size_t>(found[i].reference)].pt;
    const CellMotion* motion = prior.at(point, seeds.image_size);
    if (!motion || !motion->known || !outOfView(*motion, point, image)) continue;
    ++out;
    accepted += statistics.accepted[i];
  }
  return accepted <= kMostOutOfView * out;
}

/// Leaves in `chosen` what remains to be searched in full. The features are shared out to the threads.
void GuidedSearch::Workspace::searchWindows(const Features& reference, const Features& current,
                                            const MotionPrediction& prediction, const MotionPrediction* prior) {
  const int usual_second = usualSecondDistance();
  const float largest = kLargestWindow * static_cast<float>(current.image_size.area());
  const auto usable = [&](const CellMotion* motion) {
    return motion && motion->known && 4 * motion->reach.x * motion->reach.y <= largest;
  };
  const bool leaves_out = prior && nothingOutOfView(*prior, current.image_size);
  windows.setCurrent(current, kernel, seats);
  const auto isLeft = [&](int i, int seat) {
    Match& match = matches[static_cast<size_t>(i)];
    if (match.reference != kNoMatch) return false;
    const cv::Point2f& point = reference.keypoints[static_cast<size_t>(i)].pt;
    const CellMotion* motion = prediction.at(point, reference.image_size);
    const bool seen = usable(motion);
    if (!seen && prior) motion = prior->at(point, reference.image_size);
    if (!seen && leaves_out && motion && motion->known && outOfView(*motion, point, current.image_size)) return false;
    if (!usable(motion)) return !seen;
    const NearestTwo nearest =
        windows.search(reference.descriptors.row(i), motion->predict(point), motion->reach, seat);
    // What is no better than the second of a full search that may be had elsewhere.
    const int farthest = seen ? usual_second + kBitsAboveSecond : usual_second;
    if (nearest.distance > std::min(farthest, 8 * kDescriptorBytes)) return !seen;
    match = {i, nearest.index, nearest.distance, secondDistance(nearest, usual_second)};
    return false;
  };
  left.resize(static_cast<size_t>(reference.size()));
  const auto searchShare = [&](int share, int seat) {
    const int end = std::min(reference.size(), (share + 1) * kFeaturesAShare);
    for (int i = share * kFeaturesAShare; i < end; ++i) left[static_cast<size_t>(i)] = isLeft(i, seat);
  };
  const int shares = (reference.size() + kFeaturesAShare - 1) / kFeaturesAShare;
  pool->forEach(shares, seats, searchShare);
  chosen.clear();
  for (int i = 0; i < reference.size(); ++i) {
    if (left[static_cast<size_t>(i)]) chosen.push_back(i);
  }
}

GuidedSearch::GuidedSearch(const HammingMatcherOptions& matcher, const MotionStatisticsOptions& statistics)
    : workspace_(std::make_unique<Workspace>(matcher, statistics)) {
  if (matcher.mutual) throw std::invalid_argument("GuidedSearch finds no mutual neighbours; use HammingMatcher");
}
GuidedSearch::~GuidedSearch() = default;
GuidedSearch::GuidedSearch(GuidedSearch&&) noexcept = default;
GuidedSearch& GuidedSearch::operator=(GuidedSearch&&) noexcept = default;

void GuidedSearch::match(const Features& reference, const Features& current, std::vector<Match>& matches,
                         const MotionPrediction* prior) {
  Workspace& work = *workspace_;
  if (current.size() == 0 || !work.chooseSeeds(reference)) {
    return work.matcher.match(reference.descriptors, current.descriptors, matches);
  }

  work.matches.assign(static_cast<size_t>(reference.size()), Match{kNoMatch, kNoMatch, 0, 0});
  work.takeSeeds(reference);
  work.searchAll(reference.descriptors, current.descriptors);
  work.gms.compute(work.seeds, current, work.found, work.statistics);
  const MotionPrediction& prediction = work.predictor.predict(work.seeds, current, work.found, work.statistics);
  const bool confirmed = prior && work.confirm(*prior, current);
  work.searchWindows(reference, current, prediction, confirmed ? prior : nullptr);
  work.searchAll(reference.descriptors, current.descriptors);

  matches.clear();
  for (const Match& match : work.matches) {
    if (match.reference != kNoMatch) matches.push_back(match);
  }
}

}  // namespace gms_ransac
