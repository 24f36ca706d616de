#include "features/simd_orb_extractor.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

#include "features/corner_detector.h"

namespace gms_ransac {

namespace {

constexpr int kBorder = kDescriptorRadius;  // pixels of a level without keypoints: their patches stay inside
static_assert(kEdgeRadius < kBorder);
constexpr int kPatchSize = 31;  // side of the described patch, as cv::ORB states it
// Grey levels. Fainter corners are seldom found again, so the second holds only for levels that lack corners.
constexpr int kContrastFloor = 7;  // measured in doc/extractor.md
constexpr int kFaintFloor = 4;     // the same, doc/extractor.md
// An image is sparse if it has fewer corners per pixel. Then edge points are removed (with many corners, better ones
// win anyway) and orientations come from the sharp image. In a large image only so many pixels per keypoint count: it
// shows no more things than a small one.
constexpr double kSparse = 0.01;  // tum_fr3_cabinet has at most 0.0093, every textured set more than 0.0127
constexpr int kSparsePixels = 640 * 480, kSparsePixelsAKeypoint = 375;
constexpr double kLevelPower = 1.4;  // features of a level fall with scale^-1.4 (cv::ORB: 1, area: 2); doc/extractor.md

/// Abscissa of the extremum of the parabola through (-1, before), (0, at), (1, after), less than half a pixel.
float vertex(int before, int at, int after) {
  constexpr float kFarthest = 0.49f;
  const int curvature = before - 2 * at + after;
  if (curvature >= 0) return 0;
  const float x = 0.5f * static_cast<float>(before - after) / static_cast<float>(curvature);
  return std::max(-kFarthest, std::min(kFarthest, x));
}

int weakest(const std::vector<Corner>& corners) {
  int least = corners.empty() ? 0 : corners.front().strength;
  for (const Corner& corner : corners) least = std::min<int>(least, corner.strength);
  return least;
}

}  // namespace

SimdOrbExtractor::SimdOrbExtractor(const FeatureExtractorOptions& options)
    : options_(options),
      kernels_(featureKernels(options.simd)),
      pyramid_(options.pyramid_levels, options.pyramid_scale, 2 * kBorder + 1, kernels_),
      levels_(options.pyramid_levels),
      scratch_(std::min(options.threads, options.pyramid_levels)) {
  double sum = 0;
  for (int i = 0; i < options.pyramid_levels; ++i)
    sum += levels_[i].weight = std::pow(pyramid_.nominalScale(i), -kLevelPower);
  for (Level& level : levels_) level.weight /= sum;
  pool_ = WorkerPool::shared(static_cast<int>(scratch_.size()) - 1);
}

void SimdOrbExtractor::extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) {
  wanted_ = std::min(options_.features, at_most);
  features.image_size = image.size();
  features.scale_factor = static_cast<float>(options_.pyramid_scale);
  pyramid_.build(image);
  // The levels built last are still in the cache; so are, afterwards, the level and the contrasts searched last.
  forEachLevel(Order::kSmallestFirst, [&](int i, Scratch&) { detect(i, mask); });
  sparse_ = isSparse(mask, image);
  if (sparse_) {
    forEachLevel(Order::kLargestFirst,
                 [&](int i, Scratch&) { removeEdgePoints(pyramid_.level(i), levels_[i].corners); });
  }
  setQuotas();
  // A level that gives all its corners may have more. Those of the others become fewer then, so that none joins it.
  const auto exhausted = [](const Level& level) { return level.corners.size() <= static_cast<size_t>(level.quota); };
  if (completeWhere(mask, exhausted)) setQuotas();
  int total = 0;
  for (int i = 0; i < pyramid_.levels(); ++i) {
    levels_[i].first_keypoint = total;
    total += levels_[i].quota;
  }
  features.keypoints.resize(total);
  features.descriptors.resize(total);
  reserveScratch();
  forEachLevel(Order::kLargestFirst, [&](int i, Scratch& scratch) {
    select(i, mask, scratch.selector);
    describe(i, scratch, features);
  });
  features.descriptors.pack();
}

template <typename Task>
void SimdOrbExtractor::forEachLevel(Order order, const Task& task) {
  const int count = pyramid_.levels(), seats = static_cast<int>(scratch_.size());
  const bool reversed = order == Order::kSmallestFirst && seats == 1;
  pool_->forEach(count, seats, [&](int i, int seat) { task(reversed ? count - 1 - i : i, scratch_[seat]); });
}

void SimdOrbExtractor::reserveScratch() {
  if (pyramid_.levels() == 0) return;
  const Plane& largest = pyramid_.level(0);
  for (Scratch& scratch : scratch_) {
    scratch.selector.reserve(levels_[0].corners.capacity(), options_.features);
    scratch.blur.reserve(largest.width());
    scratch.directions.reserve(options_.features);
    scratch.blurred.resize(largest.width(), largest.height());
  }
}

void SimdOrbExtractor::detect(int i, const cv::Mat& mask) {
  const int strength_floor = levels_[i].forecast.floor();
  if (strength_floor == 0) return detectAll(i, mask);
  search(i, {kContrastFloor, strength_floor}, mask);
  if (!hasEnough(levels_[i])) complete(i, mask);
}

void SimdOrbExtractor::detectAll(int i, const cv::Mat& mask) {
  search(i, {kContrastFloor, 0}, mask);
  if (!hasEnough(levels_[i])) search(i, {kFaintFloor, 0}, mask);
}

void SimdOrbExtractor::complete(int i, const cv::Mat& mask) {
  levels_[i].forecast.fail();
  detectAll(i, mask);
}

template <typename Lacking>
bool SimdOrbExtractor::completeWhere(const cv::Mat& mask, const Lacking& lacking) {
  const auto incomplete = [&](const Level& level) { return level.strength_floor > 0 && lacking(level); };
  if (std::none_of(levels_.begin(), levels_.begin() + pyramid_.levels(), incomplete)) return false;
  forEachLevel(Order::kSmallestFirst, [&](int i, Scratch&) {
    if (incomplete(levels_[i])) complete(i, mask);
  });
  return true;
}

void SimdOrbExtractor::search(int i, const CornerFloors& floors, const cv::Mat& mask) {
  Level& level = levels_[i];
  const CornerFloors used = {std::min(options_.fast_threshold, floors.contrast), floors.strength};
  level.met = level.detector.detect(pyramid_.level(i), kBorder, used, kernels_, level.corners);
  level.strength_floor = floors.strength;
  if (mask.empty()) return;
  removeMasked(i, mask);
  level.met = level.corners.size();
}

bool SimdOrbExtractor::hasEnough(const Level& level) const {
  return static_cast<double>(level.corners.size()) >= wanted_ * level.weight;
}

void SimdOrbExtractor::removeMasked(int i, const cv::Mat& mask) {
  std::vector<Corner>& corners = levels_[i].corners;
  const auto masked = [&](const Corner& corner) {
    const cv::Point2f at = positionInImage(i, corner);
    return mask.at<uint8_t>(cvRound(at.y), cvRound(at.x)) == 0;
  };
  corners.erase(std::remove_if(corners.begin(), corners.end(), masked), corners.end());
}

size_t SimdOrbExtractor::cornerCount() const {
  size_t count = 0;  // levels beyond those of this image hold what an image before left
  for (int i = 0; i < pyramid_.levels(); ++i) count += levels_[i].met;
  return count;
}

bool SimdOrbExtractor::isSparse(const cv::Mat& mask, const cv::Mat& image) {
  const int pixels = mask.empty() ? static_cast<int>(image.total()) : cv::countNonZero(mask);
  const double least = kSparse * std::min(pixels, std::max(kSparsePixels, kSparsePixelsAKeypoint * wanted_));
  const auto few = [&] { return static_cast<double>(cornerCount()) < least; };
  return few() && (!completeWhere(mask, [](const Level&) { return true; }) || few());
}

void SimdOrbExtractor::setQuotas() {
  constexpr int kOpen = -1;
  const int count = pyramid_.levels();
  double weight = 0;
  for (int i = 0; i < count; ++i) {
    weight += levels_[i].weight;
    levels_[i].quota = kOpen;
  }
  int left = wanted_;
  for (int i = 0; i < count; ++i) {
    Level& level = levels_[i];
    if (level.quota != kOpen || static_cast<double>(level.corners.size()) > left * levels_[i].weight / weight) continue;
    level.quota = static_cast<int>(level.corners.size());
    left -= level.quota;
    weight -= levels_[i].weight;
    i = -1;  // the share of the others has grown: look at them all again
  }
  double share = 0;
  int given = 0;
  for (int i = 0; i < count; ++i) {
    if (levels_[i].quota != kOpen) continue;
    share += left * levels_[i].weight / weight;
    levels_[i].quota = static_cast<int>(std::lrint(share)) - given;
    given += levels_[i].quota;
  }
}

void SimdOrbExtractor::select(int i, const cv::Mat& mask, CornerSelector& selector) {
  Level& level = levels_[i];
  const Plane& image = pyramid_.level(i);
  const auto trySelection = [&] {
    return selector.select(image.width(), image.height(), level.quota, level.strength_floor, level.corners);
  };
  size_t found = level.corners.size();
  if (!trySelection()) {
    complete(i, mask);
    found = level.corners.size();
    trySelection();
  }
  const bool all_kept = found == level.corners.size();
  level.forecast.learn(all_kept || sparse_ ? 0 : weakest(level.corners));
}

void SimdOrbExtractor::describe(int i, Scratch& scratch, Features& features) {
  const Level& level = levels_[i];
  const Plane& image = pyramid_.level(i);
  if (level.corners.empty()) return;
  // One step after the other for all corners, which do not wait for each other; positions while contrasts are cached.
  cv::KeyPoint* keypoints = features.keypoints.data() + level.first_keypoint;
  locate(i, keypoints);
  scratch.blur.apply(image, level.corners, kernels_, scratch.blurred);
  // The centroid of the blurred disc is more stable than cv::ORB's, except where corners are faint (doc/extractor.md).
  orient(sparse_ ? image : scratch.blurred, level.corners, keypoints, scratch.directions);
  for (size_t k = 0; k < level.corners.size(); ++k) {
    const Corner& corner = level.corners[k];
    kernels_.describe(scratch.blurred.row(corner.y) + corner.x, scratch.blurred.stride(), scratch.directions[k].x,
                      scratch.directions[k].y, features.descriptors.row(level.first_keypoint + static_cast<int>(k)));
  }
}

void SimdOrbExtractor::locate(int i, cv::KeyPoint* keypoints) const {
  const float size = kPatchSize * static_cast<float>(pyramid_.nominalScale(i));
  for (const Corner& corner : levels_[i].corners) {
    cv::KeyPoint& keypoint = *keypoints++;
    keypoint.pt = positionInImage(i, corner);
    keypoint.size = size;
    keypoint.response = static_cast<float>(corner.contrast - 1);
    keypoint.octave = i;
    keypoint.class_id = -1;
  }
}

void SimdOrbExtractor::orient(const Plane& image, const std::vector<Corner>& corners, cv::KeyPoint* keypoints,
                              std::vector<cv::Point2f>& directions) const {
  directions.resize(corners.size());
  for (size_t k = 0; k < corners.size(); ++k) {
    int m10, m01;
    kernels_.moments(image.row(corners[k].y) + corners[k].x, image.stride(), m10, m01);
    keypoints[k].angle = cv::fastAtan2(static_cast<float>(m01), static_cast<float>(m10));
    const float radians = keypoints[k].angle * static_cast<float>(CV_PI / 180);
    directions[k] = {std::cos(radians), std::sin(radians)};
  }
}

cv::Point2f SimdOrbExtractor::refine(int level, const Corner& corner) const {
  const Plane& contrast = levels_[level].detector.contrast();
  const uint8_t* at = contrast.row(corner.y) + corner.x;
  const ptrdiff_t down = contrast.stride();
  const auto column = [&](int x) { return at[x - down] + 2 * at[x] + at[x + down]; };
  const auto row = [&](int y) { return at[y * down - 1] + 2 * at[y * down] + at[y * down + 1]; };
  return {corner.x + vertex(column(-1), column(0), column(1)), corner.y + vertex(row(-1), row(0), row(1))};
}

cv::Point2f SimdOrbExtractor::positionInImage(int level, const Corner& corner) const {
  const cv::Point2f position = refine(level, corner), scale = pyramid_.scale(level);
  // Pixel x of a level covers x * scale .. (x + 1) * scale of the image; cv::ORB takes x * scale.
  return {(position.x + 0.5f) * scale.x - 0.5f, (position.y + 0.5f) * scale.y - 0.5f};
}

}  // namespace gms_ransac
