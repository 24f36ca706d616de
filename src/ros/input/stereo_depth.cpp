#include "input/stereo_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "gms_ransac/camera.h"
#include "input/waiting_images.h"
#include "quantiles.h"
#include "text.h"

namespace gms_ransac {

namespace {

// With a smaller disparity the depth is unknown: half a pixel of noise is a sixth of three pixels.
constexpr double kLeastDisparity = 3;  // pixels
// Intrinsics that differ by less are those of P, and the image is rectified.
constexpr double kSameFocalLength = 1e-6;  // relative
// Share of the left keypoints that have a match on their row, of two cameras that see the same; a third in the rendered
// room. Below it a second search looks that many pixels above and below the rows. If it finds so many matches, and so
// many times more than on the rows, the rows are wrong.
constexpr double kUsualOnRows = 0.1, kBesideRows = 40;
constexpr size_t kSureBesideRows = 50, kMoreBesideRows = 3;

/// Identity where the model's pixels are those of the rectified camera.
Eigen::Matrix3d rectification(const CameraModel& model, const sensor_msgs::CameraInfo& info) {
  const double fx = model.camera.intrinsics().fx * std::max(info.binning_x, 1u);
  const bool is_rectified = model.rectified() && std::abs(fx - info.P[0]) <= kSameFocalLength * fx;
  const bool given = info.R[0] != 0 || info.R[1] != 0 || info.R[2] != 0;
  if (is_rectified || !given) return Eigen::Matrix3d::Identity();
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.R.data());
}

/// x of the left camera in the frame of this one, metres.
double offset(const sensor_msgs::CameraInfo& info) { return info.P[0] > 0 ? info.P[3] / info.P[0] : 0; }

RectifiedRays rectifiedRays(const Features& features, const Camera& camera, const Eigen::Matrix3d& turn) {
  RectifiedRays rays;
  rays.reserve(features.keypoints.size());
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    rays.push_back((turn * rayOf(camera, keypoint.pt).homogeneous()).hnormalized());
  }
  return rays;
}

}  // namespace

StereoRig::StereoRig(const CameraModel& left_model, const sensor_msgs::CameraInfo& left_info,
                     const CameraModel& right_model, const sensor_msgs::CameraInfo& right_info)
    : left(rectification(left_model, left_info)),
      right(rectification(right_model, right_info)),
      baseline(offset(left_info) - offset(right_info)) {
  const auto is_rotation = [](const Eigen::Matrix3d& R) { return R.isUnitary(1e-4) && R.determinant() > 0; };
  if (!is_rotation(left) || !is_rotation(right)) {
    problem = "R of a camera_info is no rotation; calibrate both cameras together";
  } else if (!std::isfinite(baseline) || baseline <= 0) {
    problem =
        "the camera_infos give no distance between the cameras (P[3] of the right one must be -fx times it, metres); "
        "calibrate both cameras together, and check that left and right are not exchanged";
  }
}

void StereoColumns::clear() {
  depth.clear();
  right_ray.clear();
  rig.reset();
}

StereoDepth::StereoDepth(const Parameters& parameters, const std::string& right_topic,
                         const std::string& right_info_topic)
    : right_topic_(right_topic),
      right_info_topic_(right_info_topic),
      camera_source_(parameters, right_topic, right_info_topic) {}

std::string StereoDepth::take(const ImageWithInfo& input, const Features& left, const CameraModel& left_model,
                              StereoColumns& columns) {
  columns.clear();
  if (!left_model.camera.calibrated()) return "the left camera is not calibrated";
  if (!input.right) {
    return "no image on " + right_topic_ + " has its stamp (within " + secondsText(kStereoTolerance) +
           "); trigger both cameras together, or stamp their images alike";
  }
  if (!input.right_info) return "no camera_info has come on " + right_info_topic_;
  const std::string defect = converter_.toGrey(*input.right, columns.right);
  if (!defect.empty()) return "the image on " + right_topic_ + " cannot be used: " + defect;
  if (columns.right.size() != left.image_size) {
    return "the left image is " + sizeText(left.image_size) + ", that on " + right_topic_ + " " +
           sizeText(columns.right.size()) + "; both must be of one size";
  }
  columns.right_camera = camera_source_.get(input.right_info, columns.right.size());
  if (!columns.right_camera->problem.empty()) return columns.right_camera->problem;
  const StereoRig rig(left_model, *input.camera_info, *columns.right_camera, *input.right_info);
  if (rig.problem.empty()) columns.rig = rig;
  return rig.problem;
}

std::string StereoDepth::fill(const Features& left, const CameraModel& left_model, MatchFilter& filter,
                              StereoColumns& columns) {
  const StereoRig rig = *columns.rig;
  columns.rig.reset();
  filter.extract(columns.right, right_);
  left_rays_ = rectifiedRays(left, left_model.camera, rig.left);
  right_rays_ = rectifiedRays(right_.features, columns.right_camera->camera, rig.right);
  const double focal_length = left_model.camera.meanFocalLength();
  matchRows(left, left_rays_, right_.features, right_rays_, focal_length, kUsualRowTolerance, matches_);
  std::string doubt = doubtOfRows(left, focal_length);
  if (!doubt.empty()) return doubt;

  const double nan = std::numeric_limits<double>::quiet_NaN();
  columns.depth.assign(left.keypoints.size(), 0);
  columns.right_ray.assign(left.keypoints.size(), {nan, nan});
  for (const StereoMatch& match : matches_) {
    const Eigen::Vector2d& ray = left_rays_[match.left];
    const double disparity = ray.x() - right_rays_[match.right].x();
    columns.right_ray[match.left] = rayOf(columns.right_camera->camera, right_.features.keypoints[match.right].pt);
    if (disparity * focal_length < kLeastDisparity) continue;
    const Eigen::Vector3d point = rig.left.transpose() * (rig.baseline / disparity * ray.homogeneous());
    columns.depth[match.left] = static_cast<float>(point.z());
  }
  columns.rig = rig;
  return std::string();
}

std::string StereoDepth::doubtOfRows(const Features& left, double focal_length) const {
  if (static_cast<double>(matches_.size()) >= kUsualOnRows * left.size()) return std::string();
  std::vector<StereoMatch> beside;
  matchRows(left, left_rays_, right_.features, right_rays_, focal_length, kBesideRows, beside);
  if (beside.size() < std::max(kSureBesideRows, kMoreBesideRows * matches_.size())) return std::string();
  std::vector<double> off;
  off.reserve(beside.size());
  for (const StereoMatch& match : beside) {
    off.push_back(focal_length * std::abs(left_rays_[match.left].y() - right_rays_[match.right].y()));
  }
  std::ostringstream text;
  text.precision(2);
  text << "points of the left image lie " << quantilesOf(std::move(off)).median << " px above or below their rows on "
       << right_topic_ << ": rectify both images, by the calibration in their camera_info";
  return text.str();
}

}  // namespace gms_ransac
