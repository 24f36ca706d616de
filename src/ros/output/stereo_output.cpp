#include "output/stereo_output.h"

#include <cmath>
#include <utility>
#include <vector>

#include <ros/advertise_options.h>
#include <Eigen/Geometry>
#include <boost/algorithm/string/replace.hpp>
#include <boost/make_shared.hpp>

#include "gms_ransac/camera.h"
#include "output/output_options.h"
#include "tracks/patch.h"

namespace gms_ransac {

namespace {

// Pixels around a guess within which alignment finds the point, and within which it is searched along the row.
constexpr float kReach = 3;
constexpr int kRowReach = 12;
// Largest distance of the point from its row, pixels.
constexpr double kRowTolerance = 1;

Eigen::Vector2d rotated(const Eigen::Matrix3d& R, const Eigen::Vector2d& ray) {
  return (R * ray.homogeneous()).hnormalized();
}

ros::AdvertiseOptions advertiseOptions(const std::string& type, const ros::SubscriberStatusCallback& changed) {
  auto options = ros::AdvertiseOptions::create<StereoFeatures>("stereo_features", kPublisherQueue, changed, changed,
                                                               ros::VoidConstPtr(), nullptr);
  // The md5sum depends on the fields alone. The definition, which bags keep, names the package of the nested type.
  options.datatype = type;
  boost::replace_all(options.message_definition, "gms_ransac/", type.substr(0, type.find('/') + 1));
  return options;
}

}  // namespace

std::optional<StereoFeatures> StereoFeatureStream::next(const ProcessedFrame& processed,
                                                        const FeatureOptions& options) {
  if (processed.continuity != Continuity::kContinuous) reset();
  const PreparedFrame& current = *processed.current;
  if (!current.stereo.rig) return std::nullopt;
  std::unordered_map<uint32_t, RightPoint> right;
  const auto usable = [&](const TrackedPoint& point) {
    const auto located = locate(current, point, *processed.result);
    if (located) right.emplace(point.id, *located);
    return located.has_value();
  };
  const auto features = stream_.next(processed, options, usable);
  if (!features) return std::nullopt;
  right_.swap(right);
  StereoFeatures message;
  message.header = current.header;
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

std::optional<StereoFeatureStream::RightPoint> StereoFeatureStream::locate(const PreparedFrame& current,
                                                                           const TrackedPoint& point,
                                                                           const MatchResult& result) const {
  const StereoRig& rig = *current.stereo.rig;
  const Camera &left_camera = current.camera->camera, &right_camera = current.stereo.right_camera->camera;
  const double focal_length = left_camera.meanFocalLength();
  const Eigen::Vector2d left = rotated(rig.left, rayOf(left_camera, point.current));
  const auto place = [&](double disparity) {
    const Eigen::Vector2d ray = rotated(rig.right.transpose(), {left.x() - disparity, left.y()});
    const cv::Point2f pixel = pixelOf(right_camera, ray);
    PatchPlace at;
    at.centre = {pixel.x, pixel.y};
    return at;
  };
  std::vector<double> guesses;  // disparity in the last message, and that of the keypoint by its descriptor
  const auto before = right_.find(point.id);
  if (before != right_.end()) guesses.push_back(before->second.disparity);
  if (const int match = stream_.matchOf(point.id); match >= 0) {
    const double x = rotated(rig.right, current.stereo.right_ray[result.matches[match].current]).x();
    if (std::isfinite(x)) guesses.push_back(left.x() - x);
  }
  Patch patch;
  if (guesses.empty() || !patch.take(current.grey, {point.current.x, point.current.y})) return std::nullopt;
  const cv::Mat& image = current.stereo.right;
  std::optional<PatchPlace> found = patch.find(image, place(guesses.back()), kReach);
  if (!found) {
    std::vector<PatchPlace> row;
    for (const double guess : guesses) {
      for (int i = -kRowReach; i <= kRowReach; ++i) row.push_back(place(guess + i / focal_length));
    }
    found = patch.find(image, row, kReach);
  }
  if (!found) return std::nullopt;
  const Eigen::Vector2d ray = rayOf(right_camera, {found->centre.x(), found->centre.y()});
  const Eigen::Vector2d right = rotated(rig.right, ray);
  const bool on_row = std::abs(right.y() - left.y()) * focal_length <= kRowTolerance;
  if (!on_row || right.x() >= left.x()) return std::nullopt;
  return RightPoint{ray, left.x() - right.x()};
}

StereoOutput::StereoOutput(ros::NodeHandle& outputs, const std::string& type,
                           const ros::SubscriberStatusCallback& listeners_changed) {
  auto options = advertiseOptions(type, listeners_changed);
  publisher_ = outputs.advertise(options);
}

void StereoOutput::publish(const ProcessedFrame& processed, const FeatureOptions& options) {
  if (listeners() == 0) return stream_.reset();
  auto message = stream_.next(processed, options);
  if (message) publisher_.publish(boost::make_shared<StereoFeatures>(std::move(*message)));
}

}  // namespace gms_ransac
