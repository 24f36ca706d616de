#include "gms/guided_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <stdexcept>

#include "gms/motion_prediction.h"
#include "matching/hamming_kernels.h"
#include "support/worker_pool.h"

namespace gms_ransac {

namespace {

constexpr float kKeypointsABucket = 2;
constexpr float kLeastSide = 2;  ///< of a bucket, pixels

/// The first matches, searched in full, are those of the strongest keypoints in so many parts of the image, or of one
/// part for so many keypoints.
constexpr int kSeedsAPart = 4;
constexpr int kFewestParts = 100;
constexpr int kKeypointsAPart = 50;
/// With fewer keypoints for each seed, in either image, the search is full: a guided one takes about as long, and poses
/// of tum_fr3_cabinet were worse with it from 3 on.
constexpr int kLeastKeypointsASeed = 4;

/// Bits above the usual second distance up to which a match is taken: the least of 0, 15, 25 that loses no right match.
constexpr int kBitsAboveSecond = 25;
/// Largest window, as a share of the image.
constexpr float kLargestWindow = 0.1f;
constexpr int kFeaturesAShare = 256;  ///< that one thread looks for in a row: 0.1 ms

// A prior is confirmed if more first matches agree with it than by chance, by this factor and these standard
// deviations.
constexpr double kTimesChance = 3, kSigmasAboveChance = 5;
// Largest share of first matches accepted out of view for the prior's view to be trusted (doc/inside/guided_search.md).
constexpr double kMostOutOfView = 0.1;

constexpr int kNoMatch = -1;

void insertByStrength(const std::vector<cv::KeyPoint>& keypoints, int i, int* strongest) {
  const auto response = [&](int k) { return keypoints[static_cast<size_t>(k)].response; };
  int rank = kSeedsAPart;
  while (rank > 0 && (strongest[rank - 1] == kNoMatch || response(strongest[rank - 1]) < response(i))) --rank;
  if (rank == kSeedsAPart) return;
  std::copy_backward(strongest + rank, strongest + kSeedsAPart - 1, strongest + kSeedsAPart);
  strongest[rank] = i;
}

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

void GuidedWindows::setCurrent(const Features& current, const HammingKernel& kernel, int threads) {
  kernel_ = &kernel;
  const auto n = static_cast<size_t>(current.size());
  const cv::Size image = current.image_size;
  const float area_a_bucket = kKeypointsABucket * static_cast<float>(image.area()) / static_cast<float>(n);
  buckets_per_pixel_ = 1 / std::max(std::sqrt(area_a_bucket), kLeastSide);
  columns_ = static_cast<int>(static_cast<float>(image.width) * buckets_per_pixel_) + 1;
  rows_ = static_cast<int>(static_cast<float>(image.height) * buckets_per_pixel_) + 1;

  // Counting sort; keypoints of one bucket stay in order. first_[b + 1] is where the next one of bucket b goes.
  first_.assign(static_cast<size_t>(columns_) * rows_ + 2, 0);
  bucket_.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const cv::Point2f& point = current.keypoints[i].pt;
    bucket_[i] = row(point.y) * columns_ + column(point.x);
    ++first_[static_cast<size_t>(bucket_[i]) + 2];
  }
  for (size_t b = 2; b < first_.size(); ++b) first_[b] += first_[b - 1];
  index_.resize(n + kRowsReadPast);
  descriptors_.resize((n + kRowsReadPast) * kHammingBytes);
  for (size_t i = 0; i < n; ++i) {
    const auto place = static_cast<size_t>(first_[static_cast<size_t>(bucket_[i]) + 1]++);
    index_[place] = static_cast<int32_t>(i);
    std::memcpy(&descriptors_[place * kHammingBytes], current.descriptors.row(static_cast<int>(i)), kHammingBytes);
  }
  runs_.resize(static_cast<size_t>(rows_) * static_cast<size_t>(threads));
}

NearestTwo GuidedWindows::search(const uint8_t* query, const cv::Point2f& center, const cv::Point2f& reach,
                                 int thread) {
  const int left = column(center.x - reach.x), right = column(center.x + reach.x);
  const int top = row(center.y - reach.y), bottom = row(center.y + reach.y);
  RowRun* runs = &runs_[static_cast<size_t>(rows_) * static_cast<size_t>(thread)];
  int run_count = 0;
  for (int y = top; y <= bottom; ++y) {
    const int32_t* buckets = &first_[static_cast<size_t>(y) * columns_];
    const RowRun run = {buckets[left], buckets[right + 1]};
    if (run.first < run.last) runs[run_count++] = run;
  }
  return kernel_->searchRuns(query, descriptors_.data(), index_.data(), runs, run_count);
}

/// Returns false if there are too few keypoints for a guided search.
bool GuidedSearch::chooseSeeds(const Features& reference, const Features& current) {
  const int wanted = std::max(kFewestParts, reference.size() / kKeypointsAPart);
  if (std::min(reference.size(), current.size()) < wanted * kSeedsAPart * kLeastKeypointsASeed) return false;
  const auto width = static_cast<float>(reference.image_size.width);
  const auto height = static_cast<float>(reference.image_size.height);
  const float side = std::sqrt(width * height / static_cast<float>(wanted));
  const int columns = std::max(static_cast<int>(std::lround(width / side)), 1);
  const int rows = std::max(static_cast<int>(std::lround(height / side)), 1);
  const auto part = [](float position, float length, int count) {
    return cellAt(position * static_cast<float>(count) / length, count);
  };
  strongest_.assign(static_cast<size_t>(columns) * rows * kSeedsAPart, kNoMatch);
  for (int i = 0; i < reference.size(); ++i) {
    const cv::Point2f& point = reference.keypoints[static_cast<size_t>(i)].pt;
    const int place = part(point.y, height, rows) * columns + part(point.x, width, columns);
    insertByStrength(reference.keypoints, i, &strongest_[static_cast<size_t>(place) * kSeedsAPart]);
  }
  chosen_.clear();
  std::copy_if(strongest_.begin(), strongest_.end(), std::back_inserter(chosen_), [](int i) { return i != kNoMatch; });
  return true;
}

void GuidedSearch::searchAll(const DescriptorSet& reference, const DescriptorSet& current) {
  rows_.resize(static_cast<int>(chosen_.size()));
  for (size_t k = 0; k < chosen_.size(); ++k) {
    std::memcpy(rows_.row(static_cast<int>(k)), reference.row(chosen_[k]), kDescriptorBytes);
  }
  matcher_.match(rows_, current, found_);
  for (const Match& match : found_) {
    const int i = chosen_[static_cast<size_t>(match.reference)];
    matches_[static_cast<size_t>(i)] = {i, match.current, match.distance, match.second_distance};
  }
}

int GuidedSearch::usualSecondDistance() const {
  std::array<int, kNoDistance + 1> counts = {};
  for (const Match& match : found_) ++counts[match.second_distance];
  int distance = 0, below = 0;
  while ((below += counts[static_cast<size_t>(distance)]) <= static_cast<int>(found_.size()) / 2) ++distance;
  return distance;
}

bool GuidedSearch::confirm(const MotionPrediction& prior, const Features& current) const {
  const auto area = static_cast<double>(current.image_size.area());
  double inside = 0, chance = 0;
  for (const Match& match : found_) {
    const cv::Point2f& from = seeds_.keypoints[static_cast<size_t>(match.reference)].pt;
    const CellMotion* motion = prior.at(from, seeds_.image_size);
    if (!motion) continue;
    const cv::Point2f apart = current.keypoints[static_cast<size_t>(match.current)].pt - motion->predict(from);
    chance += 4 * motion->reach.x * motion->reach.y / area;
    inside += std::abs(apart.x) <= motion->reach.x && std::abs(apart.y) <= motion->reach.y;
  }
  return inside > kTimesChance * chance && inside > chance + kSigmasAboveChance * std::sqrt(std::max(chance, 1.));
}

bool GuidedSearch::nothingOutOfView(const MotionPrediction& prior, const cv::Size& image) const {
  int out = 0, accepted = 0;
  for (size_t i = 0; i < found_.size(); ++i) {
    const cv::Point2f& point = seeds_.keypoints[static_cast<size_t>(found_[i].reference)].pt;
    const CellMotion* motion = prior.at(point, seeds_.image_size);
    if (!motion || !outOfView(*motion, point, image)) continue;
    ++out;
    accepted += statistics_.accepted[i];
  }
  return accepted <= kMostOutOfView * out;
}

/// Leaves in `chosen_` what remains to be searched in full. The features are shared out to the threads.
void GuidedSearch::searchWindows(const Features& reference, const Features& current, const MotionPrediction& prediction,
                                 const MotionPrediction* prior) {
  const int usual_second = usualSecondDistance();
  const float largest = kLargestWindow * static_cast<float>(current.image_size.area());
  const auto usable = [&](const CellMotion* motion) {
    return motion && 4 * motion->reach.x * motion->reach.y <= largest;
  };
  const bool leaves_out = prior && nothingOutOfView(*prior, current.image_size);
  windows_.setCurrent(current, kernel_, threads_);
  const auto isLeft = [&](int i, int thread) {
    Match& match = matches_[static_cast<size_t>(i)];
    if (match.reference != kNoMatch) return false;
    const cv::Point2f& point = reference.keypoints[static_cast<size_t>(i)].pt;
    const CellMotion* motion = prediction.at(point, reference.image_size);
    const bool seen = usable(motion);
    if (!seen && prior) motion = prior->at(point, reference.image_size);
    if (!seen && leaves_out && motion && outOfView(*motion, point, current.image_size)) return false;
    if (!usable(motion)) return !seen;
    const NearestTwo nearest =
        windows_.search(reference.descriptors.row(i), motion->predict(point), motion->reach, thread);
    // A match no better than the usual second one may be chance.
    const int farthest = seen ? usual_second + kBitsAboveSecond : usual_second;
    if (nearest.distance > std::min(farthest, 8 * kDescriptorBytes)) return !seen;
    match = {i, nearest.index, nearest.distance, secondDistance(nearest, usual_second)};
    return false;
  };
  left_.resize(static_cast<size_t>(reference.size()));
  const auto searchShare = [&](int share, int thread) {
    const int end = std::min(reference.size(), (share + 1) * kFeaturesAShare);
    for (int i = share * kFeaturesAShare; i < end; ++i) left_[static_cast<size_t>(i)] = isLeft(i, thread);
  };
  const int shares = (reference.size() + kFeaturesAShare - 1) / kFeaturesAShare;
  pool_->forEach(shares, threads_, searchShare);
  chosen_.clear();
  for (int i = 0; i < reference.size(); ++i) {
    if (left_[static_cast<size_t>(i)]) chosen_.push_back(i);
  }
}

GuidedSearch::GuidedSearch(const HammingMatcherOptions& matcher_options,
                           const MotionStatisticsOptions& statistics_options)
    : kernel_(hammingKernel(matcher_options.simd)),
      matcher_(matcher_options),
      gms_(seedStatistics(statistics_options)),
      threads_(matcher_options.threads),
      pool_(WorkerPool::shared(threads_ - 1)) {
  if (matcher_options.mutual)
    throw std::invalid_argument("GuidedSearch finds no mutual neighbours; use HammingMatcher");
}

void GuidedSearch::match(const Features& reference, const Features& current, std::vector<Match>& result,
                         const MotionPrediction* prior) {
  if (!chooseSeeds(reference, current)) {
    return matcher_.match(reference.descriptors, current.descriptors, result);
  }

  matches_.assign(static_cast<size_t>(reference.size()), Match{kNoMatch, kNoMatch, 0, 0});
  seeds_.image_size = reference.image_size;
  seeds_.scale_factor = reference.scale_factor;
  seeds_.keypoints.clear();
  for (const int i : chosen_) seeds_.keypoints.push_back(reference.keypoints[static_cast<size_t>(i)]);
  searchAll(reference.descriptors, current.descriptors);
  gms_.compute(seeds_, current, found_, statistics_);
  const MotionPrediction& prediction = predictor_.predict(seeds_, current, found_, statistics_);
  const bool confirmed = prior && confirm(*prior, current);
  searchWindows(reference, current, prediction, confirmed ? prior : nullptr);
  searchAll(reference.descriptors, current.descriptors);

  result.clear();
  for (const Match& match : matches_) {
    if (match.reference != kNoMatch) result.push_back(match);
  }
}

}  // namespace gms_ransac
