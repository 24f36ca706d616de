// The room features makes keypoints and descriptors of an image. It may become faster; the bits that it computes stay
// those of the digests, on every instruction set.
//
#include "gms_ransac/feature_extractor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "features/blur.h"
#include "features/corner_detector.h"
#include "features/corner_selector.h"
#include "features/kernels.h"
#include "features/pyramid.h"
#include "support/worker_pool.h"

namespace gms_ransac {

namespace {

constexpr int kPatchSize = 31;              // side of the described patch, as cv::ORB states it
constexpr int kBorder = kDescriptorRadius;  // pixels of a level without keypoints: their patches stay inside
static_assert(kEdgeRadius < kBorder);
// Grey levels. Fainter corners are seldom found again, so the second holds only for levels that lack corners.
constexpr int kContrastFloor = 7;  // measured in doc/measured/constants.md
constexpr int kFaintFloor = 4;     // the same, doc/measured/constants.md
// An image is sparse if it has fewer corners per pixel. Then edge points are removed (with many corners, better ones
// win anyway) and orientations come from the sharp image. In a large image only so many pixels per keypoint count: it
// shows no more things than a small one.
constexpr double kSparse = 0.01;  // tum_fr3_cabinet has at most 0.0093, every textured set more than 0.0127
constexpr int kSparsePixels = 640 * 480, kSparsePixelsAKeypoint = 375;
constexpr double kLevelPower = 1.4;  // features of a level fall with scale^-1.4 (cv::ORB: 1); doc/measured/constants.md

// An image is dark if all but its brightest 0.5 % are below the first number. Its contrasts are few grey levels, and
// FAST and the descriptors count in whole ones; where the brightest exceed the median by fewer than the second, there
// is noise and no more (doc/inside/extractor.md).
constexpr int kDark = 64, kLeastSpread = 4;
constexpr double kBrightest = 0.005;
constexpr int kSampling = 4;  ///< pixels between those that the brightness is taken from, along either side

// A small image, such as of a thermal array, is enlarged: most of it would be border. By four, 64 x 48 pixels of
// kitti_06 give 2000 keypoints instead of 30, and 39 of 39 pairs a direction instead of none; 160 x 120 need it no
// more.
constexpr int kSmallSide = 100, kSmallLength = 400, kEnlargement = 4;

/// The gain that brings a dark image to full range; 1 for any other, which its first rows tell.
double gainOf(const cv::Mat& image) {
  std::array<int, 256> histogram{};
  const auto sampled = [](int pixels) { return (pixels + kSampling - 1) / kSampling; };
  const int total = sampled(image.rows) * sampled(image.cols);
  const double brightest = kBrightest * total;
  int not_dark = 0;
  for (int y = 0; y < image.rows; y += kSampling) {
    const uint8_t* row = image.ptr(y);
    for (int x = 0; x < image.cols; x += kSampling) {
      ++histogram[row[x]];
      not_dark += row[x] >= kDark;
    }
    if (not_dark > brightest) return 1;
  }
  const auto levelAbove = [&](double pixels) {
    int level = 255;
    for (int count = histogram[255]; level > 0 && count <= pixels; count += histogram[--level]) {
    }
    return level;
  };
  const int bright = levelAbove(brightest);
  return bright - levelAbove(0.5 * total) >= kLeastSpread ? 255. / bright : 1;
}

/// Abscissa of the extremum of the parabola through (-1, before), (0, at), (1, after), less than half a pixel.
float vertex(int before, int at, int after) {
  constexpr float kFarthest = 0.49f;
  const int curvature = before - 2 * at + after;
  if (curvature >= 0) return 0;
  return std::clamp(0.5f * static_cast<float>(before - after) / static_cast<float>(curvature), -kFarthest, kFarthest);
}

/// The strength that corners of a level must exceed to become keypoints, learned from the image before.
class StrengthForecast {
 public:
  int floor() const { return pause_ > 0 ? 0 : floor_; }

  /// The strength of the weakest keypoint of an image, 0 where every corner became one.
  void update(int weakest) {
    floor_ = static_cast<int>(kShare * static_cast<float>(weakest));
    if (pause_ > 0) --pause_;
  }
  /// The floor was too high for an image, which was searched twice.
  void fail() { pause_ = kPause; }

 private:
  static constexpr float kShare = 0.85;  ///< 0.93 fails on kitti_06: a quarter more instructions
  static constexpr int kPause = 8;       ///< images; bounds what images that are not alike cost
  int floor_ = 0;
  int pause_ = 0;
};

/// Our ORB: the same descriptor as cv::ORB's on keypoints that are found faster, spread better and located more finely.
class SimdOrbExtractor : public FeatureExtractor {
 public:
  explicit SimdOrbExtractor(const FeatureExtractorOptions& options)
      : options_(options),
        kernels_(featureKernels(options.simd)),
        pyramid_(options.pyramid_levels, options.pyramid_scale, 2 * kBorder + 1, kernels_),
        levels_(options.pyramid_levels),
        scratch_(std::min(options.threads, options.pyramid_levels)),
        pool_(WorkerPool::shared(static_cast<int>(scratch_.size()) - 1)) {
    double sum = 0;
    for (int i = 0; i < options.pyramid_levels; ++i)
      sum += levels_[i].weight = std::pow(pyramid_.nominalScale(i), -kLevelPower);
    for (Level& level : levels_) level.weight /= sum;
  }

 private:
  struct Level {
    CornerDetector detector;
    std::vector<Corner> corners;  ///< all of them, then the chosen ones
    double weight = 0;            ///< share of the features asked for
    StrengthForecast forecast;
    int strength_floor = 0;  ///< corners that are not stronger were passed over; 0: none were
    size_t met = 0;          ///< corners met, weaker ones included
    int quota = 0;
    int first_keypoint = 0;
  };

  /// Scratch storage for describing a level. One for each thread instead of each level: it stays in the cache.
  struct Scratch {
    CornerSelector selector;
    Blur blur;
    Plane blurred;
    std::vector<cv::Point2f> directions;  ///< cosine and sine of each keypoint's angle
  };

  enum class Order { kLargestFirst, kSmallestFirst };

  void extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) override {
    wanted_ = std::min(options_.features, at_most);
    features.image_size = image.size();
    features.scale_factor = static_cast<float>(options_.pyramid_scale);
    const double gain = gainOf(image);
    if (gain > 1) image.convertTo(brightened_, CV_8U, gain);
    pyramid_.build(gain > 1 ? brightened_ : image);
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

  /// Calls task(level, scratch) for every level on all threads; several take the largest levels first.
  template <typename Task>
  void forEachLevel(Order order, const Task& task) {
    const int count = pyramid_.levels(), threads = static_cast<int>(scratch_.size());
    const bool reversed = order == Order::kSmallestFirst && threads == 1;
    pool_->forEach(count, threads, [&](int i, int thread) { task(reversed ? count - 1 - i : i, scratch_[thread]); });
  }

  /// Makes room in every scratch for the largest level, whichever thread takes it, so that later frames need none.
  void reserveScratch() {
    if (pyramid_.levels() == 0) return;
    const Plane& largest = pyramid_.level(0);
    for (Scratch& scratch : scratch_) {
      scratch.selector.reserve(levels_[0].corners.capacity(), options_.features);
      scratch.blur.reserve(largest.width());
      scratch.directions.reserve(options_.features);
      scratch.blurred.resize(largest.width(), largest.height());
    }
  }

  /// Finds the corners of a level that may become keypoints, as the image before forecasts, or all.
  void detect(int i, const cv::Mat& mask) {
    const int strength_floor = levels_[i].forecast.floor();
    if (strength_floor == 0) return detectAll(i, mask);
    search(i, {kContrastFloor, strength_floor}, mask);
    if (!hasEnough(levels_[i])) complete(i, mask);
  }

  void detectAll(int i, const cv::Mat& mask) {
    search(i, {kContrastFloor, 0}, mask);
    if (!hasEnough(levels_[i])) search(i, {kFaintFloor, 0}, mask);
  }

  void complete(int i, const cv::Mat& mask) {
    levels_[i].forecast.fail();
    detectAll(i, mask);
  }

  /// Completes those of the incomplete levels of which `lacking` says so. False if there are none.
  template <typename Lacking>
  bool completeWhere(const cv::Mat& mask, const Lacking& lacking) {
    const auto incomplete = [&](const Level& level) { return level.strength_floor > 0 && lacking(level); };
    if (std::none_of(levels_.begin(), levels_.begin() + pyramid_.levels(), incomplete)) return false;
    forEachLevel(Order::kSmallestFirst, [&](int i, Scratch&) {
      if (incomplete(levels_[i])) complete(i, mask);
    });
    return true;
  }

  void search(int i, const CornerFloors& floors, const cv::Mat& mask) {
    Level& level = levels_[i];
    const CornerFloors used = {std::min(options_.fast_threshold, floors.contrast), floors.strength};
    level.met = level.detector.detect(pyramid_.level(i), kBorder, used, kernels_, level.corners);
    level.strength_floor = floors.strength;
    if (mask.empty()) return;
    const auto masked = [&](const Corner& corner) {
      const cv::Point2f at = positionInImage(i, corner);
      return mask.at<uint8_t>(cvRound(at.y), cvRound(at.x)) == 0;
    };
    level.corners.erase(std::remove_if(level.corners.begin(), level.corners.end(), masked), level.corners.end());
    level.met = level.corners.size();
  }

  bool hasEnough(const Level& level) const {
    return static_cast<double>(level.corners.size()) >= wanted_ * level.weight;
  }

  bool isSparse(const cv::Mat& mask, const cv::Mat& image) {
    const int pixels = mask.empty() ? static_cast<int>(image.total()) : cv::countNonZero(mask);
    const double least = kSparse * std::min(pixels, std::max(kSparsePixels, kSparsePixelsAKeypoint * wanted_));
    const auto few = [&] {
      size_t count = 0;  // levels beyond those of this image hold what an image before left
      for (int i = 0; i < pyramid_.levels(); ++i) count += levels_[i].met;
      return static_cast<double>(count) < least;
    };
    return few() && (!completeWhere(mask, [](const Level&) { return true; }) || few());
  }

  /// Divides the features among the levels by weight; what a level lacks goes to the others.
  void setQuotas() {
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
      if (level.quota != kOpen || static_cast<double>(level.corners.size()) > left * level.weight / weight) continue;
      level.quota = static_cast<int>(level.corners.size());
      left -= level.quota;
      weight -= level.weight;
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

  void select(int i, const cv::Mat& mask, CornerSelector& selector) {
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
    int weakest = 0;
    if (found > level.corners.size() && !sparse_) {
      const auto weaker = [](const Corner& a, const Corner& b) { return a.strength < b.strength; };
      const auto least = std::min_element(level.corners.begin(), level.corners.end(), weaker);
      weakest = least == level.corners.end() ? 0 : least->strength;
    }
    level.forecast.update(weakest);
  }

  void describe(int i, Scratch& scratch, Features& features) {
    const std::vector<Corner>& corners = levels_[i].corners;
    const Plane& image = pyramid_.level(i);
    if (corners.empty()) return;
    // One step after the other for all corners, which do not wait for each other; positions while contrasts are cached.
    cv::KeyPoint* keypoints = features.keypoints.data() + levels_[i].first_keypoint;
    const float size = kPatchSize * static_cast<float>(pyramid_.nominalScale(i));
    for (size_t k = 0; k < corners.size(); ++k) {
      const auto response = static_cast<float>(corners[k].contrast - 1);
      keypoints[k] = cv::KeyPoint(positionInImage(i, corners[k]), size, 0, response, i);
    }
    scratch.blur.apply(image, corners, kernels_, scratch.blurred);
    // The centroid of the blurred disc is more stable than cv::ORB's, except where corners are faint
    // (doc/inside/extractor.md).
    orient(sparse_ ? image : scratch.blurred, corners, keypoints, scratch.directions);
    for (size_t k = 0; k < corners.size(); ++k) {
      kernels_.describe(scratch.blurred.row(corners[k].y) + corners[k].x, scratch.blurred.stride(),
                        scratch.directions[k].x, scratch.directions[k].y,
                        features.descriptors.row(levels_[i].first_keypoint + static_cast<int>(k)));
    }
  }

  /// Fills in the keypoints' angles, by the intensity centroid in `image`, and their directions.
  void orient(const Plane& image, const std::vector<Corner>& corners, cv::KeyPoint* keypoints,
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

  /// Position in pixels of the image, by parabolas through the smoothed contrasts around the corner.
  cv::Point2f positionInImage(int level, const Corner& corner) const {
    const Plane& contrast = levels_[level].detector.contrast();
    const uint8_t* at = contrast.row(corner.y) + corner.x;
    const ptrdiff_t down = contrast.stride();
    const auto column = [&](int x) { return at[x - down] + 2 * at[x] + at[x + down]; };
    const auto row = [&](int y) { return at[y * down - 1] + 2 * at[y * down] + at[y * down + 1]; };
    const cv::Point2f position(corner.x + vertex(column(-1), column(0), column(1)),
                               corner.y + vertex(row(-1), row(0), row(1)));
    // Pixel x of a level covers x * scale .. (x + 1) * scale of the image; cv::ORB takes x * scale.
    const cv::Point2f scale = pyramid_.scale(level);
    return {(position.x + 0.5f) * scale.x - 0.5f, (position.y + 0.5f) * scale.y - 0.5f};
  }

  FeatureExtractorOptions options_;
  const FeatureKernels& kernels_;
  cv::Mat brightened_;
  Pyramid pyramid_;
  std::vector<Level> levels_;
  int wanted_ = 0;                ///< keypoints of this image
  bool sparse_ = false;           ///< the image has few corners
  std::vector<Scratch> scratch_;  ///< of each thread
  std::shared_ptr<WorkerPool> pool_;
};

/// Levels that leave at least a pixel of the image: cv::ORB fails an assertion on those that do not.
int levelsThatFit(const cv::Size& size, const FeatureExtractorOptions& options) {
  const double factor = static_cast<float>(options.pyramid_scale);  // as cv::ORB stores it
  const auto side = static_cast<float>(std::min(size.width, size.height));
  int levels = 1;
  while (levels < options.pyramid_levels && std::lrint(side / static_cast<float>(std::pow(factor, levels))) > 0)
    ++levels;
  return levels;
}

/// ORB as OpenCV computes it: the extractor of the paper, kept for comparison.
class OpenCvExtractor : public FeatureExtractor {
 public:
  explicit OpenCvExtractor(const FeatureExtractorOptions& options)
      : options_(options),
        orb_(cv::ORB::create(options.features, static_cast<float>(options.pyramid_scale), options.pyramid_levels,
                             kPatchSize, 0, 2, cv::ORB::HARRIS_SCORE, kPatchSize, options.fast_threshold)) {}

 private:
  void extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) override {
    features.image_size = image.size();
    features.scale_factor = static_cast<float>(options_.pyramid_scale);
    features.keypoints.clear();
    // cv::ORB fails an assertion on images that are smaller than its patch.
    if (image.cols <= 2 * kPatchSize || image.rows <= 2 * kPatchSize) {
      features.descriptors.assign(cv::Mat());
      return;
    }
    orb_->setMaxFeatures(std::min(options_.features, at_most));
    orb_->setNLevels(levelsThatFit(image.size(), options_));
    // cv::ORB scales the mask to its levels and uses what stays 255.
    cv::Mat used;
    if (!mask.empty()) used = mask != 0;
    orb_->detectAndCompute(image, used, features.keypoints, descriptors_);
    features.descriptors.assign(descriptors_);
  }

  FeatureExtractorOptions options_;
  cv::Ptr<cv::ORB> orb_;
  cv::Mat descriptors_;
};

}  // namespace

void FeatureExtractor::extract(const cv::Mat& image, Features& features, const cv::Mat& mask, int at_most) {
  if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != image.size())) {
    throw std::invalid_argument("FeatureExtractor: the mask must be CV_8UC1 and as large as the image");
  }
  const auto [shorter, longer] = std::minmax({image.cols, image.rows});
  if (image.empty() || shorter >= kSmallSide || longer >= kSmallLength) {
    return extractWhere(mask, image, at_most, features);
  }
  cv::resize(image, enlarged_, cv::Size(), kEnlargement, kEnlargement, cv::INTER_CUBIC);
  if (!mask.empty()) cv::resize(mask, enlarged_mask_, enlarged_.size(), 0, 0, cv::INTER_NEAREST);
  extractWhere(mask.empty() ? cv::Mat() : enlarged_mask_, enlarged_, at_most, features);
  features.image_size = image.size();
  for (cv::KeyPoint& keypoint : features.keypoints) {
    const cv::Point2f half(0.5f, 0.5f);
    keypoint.pt = (keypoint.pt + half) / kEnlargement - half;
    keypoint.size /= kEnlargement;
  }
}

std::unique_ptr<FeatureExtractor> makeFeatureExtractor(const FeatureExtractorOptions& options) {
  options.validate();
  if (options.extractor == "opencv") return std::make_unique<OpenCvExtractor>(options);
  return std::make_unique<SimdOrbExtractor>(options);
}

}  // namespace gms_ransac
