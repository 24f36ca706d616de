#include "features/fast_extractor.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {
constexpr int kBorder = kDescriptorRadius;  // pixels of a level without keypoints: the patch stays inside
constexpr int kPatchSize = 31;
constexpr int kContrastFloor = 5;
constexpr double kAreaPower = 1;
}  // namespace

FastExtractor::FastExtractor(const FeatureExtractorOptions& options)
    : options_(options),
      kernels_(featureKernels(options.simd)),
      pyramid_(options.levels, options.scale_factor, 2 * kBorder + 1, kernels_),
      levels_(options.levels),
      quota_(options.levels) {}

void FastExtractor::extract(const cv::Mat& image, Features& features) {
  features.image_size = image.size();
  features.scale_factor = static_cast<float>(options_.scale_factor);
  pyramid_.build(image);
  const int count = pyramid_.levels();
  for (int i = 0; i < count; ++i) detect(i);
  shareOut();
  int total = 0;
  for (int i = 0; i < count; ++i) {
    select(i);
    levels_[i].first_keypoint = total;
    total += static_cast<int>(levels_[i].corners.size());
  }
  features.keypoints.resize(total);
  features.descriptors.resize(total);
  for (int i = 0; i < count; ++i) describe(i, features);
  features.descriptors.pack();
}

void FastExtractor::detect(int i) {
  const int floor = std::min(options_.fast_threshold, kContrastFloor);
  levels_[i].detector.detect(pyramid_.level(i), kBorder, floor, kernels_, levels_[i].corners);
}

void FastExtractor::shareOut() {
  const int count = pyramid_.levels();
  std::fill(quota_.begin(), quota_.end(), 0);
  int left = options_.features;
  // Levels with too few corners give all they have; what they leave is shared among the others, so again.
  std::vector<char> full(count, 0);
  for (bool changed = true; changed && left > 0;) {
    changed = false;
    double weight = 0;
    for (int i = 0; i < count; ++i) {
      if (!full[i]) weight += std::pow(pyramid_.nominalScale(i), -kAreaPower);
    }
    int used = 0;
    for (int i = 0; i < count; ++i) {
      if (full[i]) continue;
      const double share = left * std::pow(pyramid_.nominalScale(i), -kAreaPower) / weight;
      if (levels_[i].corners.size() <= share) {
        quota_[i] = static_cast<int>(levels_[i].corners.size());
        used += quota_[i];
        full[i] = 1;
        changed = true;
      }
    }
    left -= used;
    if (changed) continue;
    double sum = 0;
    int given = 0;
    for (int i = 0; i < count; ++i) {
      if (full[i]) continue;
      sum += left * std::pow(pyramid_.nominalScale(i), -kAreaPower) / weight;
      quota_[i] = static_cast<int>(std::lrint(sum)) - given;
      given += quota_[i];
    }
  }
}

void FastExtractor::select(int i) {
  const Plane& plane = pyramid_.level(i);
  levels_[i].selector.select(plane.width(), plane.height(), quota_[i], levels_[i].corners);
}

cv::Point2f FastExtractor::refine(int level, const Corner& c) const {
  cv::Point2f p(c.x, c.y);
  const Plane& s = levels_[level].detector.contrast();
  const uint8_t* r = s.row(c.y) + c.x;
  const auto vertex = [](int a, int b, int d) {
    const int curvature = a - 2 * b + d;
    return curvature < 0 ? std::max(-0.49f, std::min(0.49f, 0.5f * (a - d) / curvature)) : 0.f;
  };
  p.x += vertex(r[-1], r[0], r[1]);
  p.y += vertex(r[-s.stride()], r[0], r[s.stride()]);
  return p;
}

void FastExtractor::describe(int i, Features& features) {
  Level& level = levels_[i];
  if (level.corners.empty()) return;
  const Plane& image = pyramid_.level(i);
  level.blur.apply(image, kernels_, level.blurred);
  const cv::Point2f scale = pyramid_.scale(i);
  const auto nominal = static_cast<float>(pyramid_.nominalScale(i));
  int index = level.first_keypoint;
  for (const Corner& corner : level.corners) {
    cv::KeyPoint& keypoint = features.keypoints[index];
    int m10, m01;
    kernels_.moments(image.row(corner.y) + corner.x, image.stride(), m10, m01);
    keypoint.angle = cv::fastAtan2(static_cast<float>(m01), static_cast<float>(m10));
    const cv::Point2f p = refine(i, corner);
    keypoint.pt = {(p.x + 0.5f) * scale.x - 0.5f, (p.y + 0.5f) * scale.y - 0.5f};
    keypoint.size = kPatchSize * nominal;
    keypoint.response = static_cast<float>(corner.contrast - 1);
    keypoint.octave = i;
    keypoint.class_id = -1;
    const float radians = keypoint.angle * static_cast<float>(CV_PI / 180);
    kernels_.describe(level.blurred.row(corner.y) + corner.x, level.blurred.stride(), std::cos(radians),
                      std::sin(radians), features.descriptors.row(index));
    ++index;
  }
}

}  // namespace gms_ransac
