#include "output/stereo_feature_stream.h"

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "gms_ransac/camera.h"
#include "input/stereo_depth.h"
#include "matching/patch.h"

namespace gms_ransac {

namespace {

// Pixels around a guess within which alignment finds the point, and within which it is searched along the row.
constexpr float kReach = 3;
constexpr int kRowReach = 12;
// Without a guess it is searched on the row at disparities up to this share of the width, in these steps, pixels.
constexpr double kGreatestDisparity = 0.25;
constexpr int kRowStep = 2;
// Largest distance of the point from its row, pixels.
constexpr double kRowTolerance = 1;

// A point is that of the other image if the search back ends so near to it, pixels.
constexpr float kMutual = 1;

/// One image of the pair.
struct Side {
  const cv::Mat& image;
  const Camera& camera;
  const Eigen::Matrix3d& rectification;

  Eigen::Vector2d rectified(const Eigen::Vector2d& ray) const { return rotated(rectification, ray); }
  Eigen::Vector2d rayAt(const PatchPlace& place) const { return rayOf(camera, {place.centre.x(), place.centre.y()}); }
  /// Where a rectified ray meets the image.
  PatchPlace place(const Eigen::Vector2d& rectified_ray) const {
    const cv::Point2f pixel = pixelOf(camera, rotated(rectification.transpose(), rectified_ray));
    PatchPlace at;
    at.centre = {pixel.x, pixel.y};
    return at;
  }
};

/// Finds the patch on the row of a rectified ray; `sign`: direction in x.
std::optional<PatchPlace> searchRow(const Patch& patch, const Side& side, const Eigen::Vector2d& ray, int sign) {
  const double step = sign / side.camera.meanFocalLength();
  std::vector<PatchPlace> row;
  for (int i = 0; i <= kGreatestDisparity * side.image.cols; i += kRowStep) {
    row.push_back(side.place({ray.x() + i * step, ray.y()}));
  }
  return patch.find(side.image, row, {kReach});
}

/// True if the patch at `found` leads back to `point` of the other side.
bool isMutual(const Side& side, const PatchPlace& found, const Side& other, const cv::Point2f& point) {
  Patch patch;
  if (!patch.cut(side.image, found.centre)) return false;
  const auto back = searchRow(patch, other, side.rectified(side.rayAt(found)), 1);
  return back && (back->centre - Eigen::Vector2f(point.x, point.y)).norm() <= kMutual;
}

}  // namespace

std::optional<StereoFeatures> StereoFeatureStream::next(const ProcessedFrame& processed,
                                                        const FeatureOptions& options) {
  if (processed.continuity != Continuity::kContinuous) reset();
  const PreparedFrame& current = *processed.current;
  if (!current.stereo.rig) return std::nullopt;
  std::unordered_map<uint32_t, RightPoint> right;
  int tried = 0;
  const auto usable = [&](const TrackedPoint& point) {
    ++tried;
    const auto located = locate(current, point, processed.pair->result);
    if (located) right.emplace(point.id, *located);
    return located.has_value();
  };
  const auto features = stream_.next(processed, options, usable);
  if (!features) return std::nullopt;
  right_.swap(right);
  tried_ = tried;
  found_ = static_cast<int>(right_.size());
  StereoFeatures message;
  message.header = current.image.header;
  for (const Feature& feature : *features) {
    const Eigen::Vector2d& ray = right_.at(feature.id).ray;
    StereoFeature both;
    both.id = feature.id;
    both.u0 = feature.ray.x();
    both.v0 = feature.ray.y();
    both.u1 = ray.x();
    both.v1 = ray.y();
    message.features.push_back(both);
  }
  return message;
}

void StereoFeatureStream::reset() {
  stream_.reset();
  right_.clear();
  tried_ = found_ = 0;
}

std::optional<StereoFeatureStream::RightPoint> StereoFeatureStream::locate(const PreparedFrame& current,
                                                                           const TrackedPoint& point,
                                                                           const MatchResult& result) const {
  const StereoRig& rig = *current.stereo.rig;
  const Side left = {current.image.grey, current.image.camera->camera, rig.left};
  const Side right = {current.stereo.right, current.stereo.right_camera->camera, rig.right};
  const double focal_length = left.camera.meanFocalLength(), pixel = 1 / focal_length;
  const Eigen::Vector2d seen = left.rectified(rayOf(left.camera, point.current));
  const auto at = [&](double disparity) { return right.place({seen.x() - disparity, seen.y()}); };
  std::vector<double> guesses;  // disparity in the last message, and that of the keypoint
  const auto before = right_.find(point.id);
  if (before != right_.end()) guesses.push_back(before->second.disparity);
  if (point.row >= 0 && !current.stereo.right_ray.empty()) {
    const double x = right.rectified(current.stereo.right_ray[result.matches[point.row].current]).x();
    if (std::isfinite(x)) guesses.push_back(seen.x() - x);
  }
  Patch patch;
  if (!patch.cut(left.image, {point.current.x, point.current.y})) return std::nullopt;
  std::optional<PatchPlace> found;
  if (guesses.empty()) {
    found = searchRow(patch, right, seen, -1);
  } else if (found = patch.find(right.image, at(guesses.back()), {kReach}); !found) {
    std::vector<PatchPlace> row;
    for (const double guess : guesses) {
      for (int i = -kRowReach; i <= kRowReach; ++i) row.push_back(at(guess + i * pixel));
    }
    found = patch.find(right.image, row, {kReach});
  }
  const bool is_new = before == right_.end();
  if (!found || (is_new && !isMutual(right, *found, left, point.current))) return std::nullopt;
  const Eigen::Vector2d ray = right.rayAt(*found), there = right.rectified(ray);
  const bool on_row = std::abs(there.y() - seen.y()) * focal_length <= kRowTolerance;
  if (!on_row || there.x() >= seen.x()) return std::nullopt;
  return RightPoint{ray, seen.x() - there.x()};
}

}  // namespace gms_ransac
