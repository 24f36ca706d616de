#include "input/stereo_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "gms_ransac/camera.h"
#include "input/waiting_images.h"
#include "quantiles.h"
#include "text.h"

namespace gms_ransac {

namespace {

// With a smaller disparity the depth is unknown: 0.2 pixels of noise are a fifth of one.
constexpr double kLeastDisparity = 1;  // pixels
// Intrinsics that differ by less are those of P, and the image is rectified.
constexpr double kSameFocalLength = 1e-6;                         // relative
constexpr double kSameRow = 0.01;                                 // pixels
constexpr double kShortestBaseline = 0.01, kLongestBaseline = 3;  // metres, of cameras on a robot or a car
// Share of the left keypoints that are found on their row. It is 0.36 to 0.66 on KITTI. If the right image is one late
// at 1.2 m an image it is at most 0.18, and 0.13 if it is two rows lower. Below the first limit some are
// searched above and below as well, and now and then of every stream: at 0.4 m an image a late one may have half.
constexpr double kUsualOnRows = 0.25, kFewOnRows = 0.1;
constexpr int kLookedAtEvery = 10;  // images
constexpr int kSearchedBeside = 125;
// Pixels above and below. Chance finds a fifth of the points somewhere in 40, so the wider search needs more of them.
constexpr int kBesideRows = 8, kFarBesideRows = 40;
constexpr size_t kSureBesideRows = 15, kSureFarBesideRows = 30;
// Points on their rows for each above or below them, from which on a doubt ends. KITTI has two to thirty, and at most
// one if the right image is one late.
constexpr double kSureOnRows = 1.5;
// Share of those searched that are found in the other direction where left and right are exchanged: 0.2 to 0.35 on
// KITTI, 0.05 if they are not.
constexpr double kExchanged = 0.15;

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

/// True if both images are those of rectified cameras, with their rows at the same height.
bool sharesRows(const Camera& left, const Camera& right, const StereoRig& rig) {
  const CameraIntrinsics &a = left.intrinsics(), &b = right.intrinsics();
  const bool alike = std::abs(a.fx - b.fx) <= kSameFocalLength * a.fx &&
                     std::abs(a.fy - b.fy) <= kSameFocalLength * a.fy && std::abs(a.cy - b.cy) <= kSameRow;
  return alike && !left.distorts() && !right.distorts() && rig.left.isIdentity() && rig.right.isIdentity();
}

/// A rectified camera that sees what the other one sees.
CameraIntrinsics rectifiedIntrinsics(const Camera& camera, const Eigen::Matrix3d& turn) {
  const cv::Size size = camera.imageSize();
  const cv::Point2f centre(0.5F * static_cast<float>(size.width), 0.5F * static_cast<float>(size.height));
  const Eigen::Vector2d ray = rotated(turn, rayOf(camera, centre));
  const double f = camera.meanFocalLength();
  return {f, f, centre.x - f * ray.x(), centre.y - f * ray.y(), {}, {}};
}

}  // namespace

Eigen::Vector2d rotated(const Eigen::Matrix3d& R, const Eigen::Vector2d& ray) {
  return (R * ray.homogeneous()).hnormalized();
}

void StereoDepth::View::set(const Camera& of, const Eigen::Matrix3d& to_rectified, const CameraIntrinsics& k) {
  if (!pixels.empty() && camera == of && turn == to_rectified) return;
  camera = of;
  turn = to_rectified;
  cv::Mat_<cv::Vec2f> map(of.imageSize());
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector3d ray = turn.transpose() * Eigen::Vector3d((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1);
      const cv::Point2f pixel = ray.z() > 0 ? pixelOf(camera, ray.hnormalized()) : cv::Point2f(-1, -1);
      map(v, u) = std::isfinite(pixel.x + pixel.y) ? cv::Vec2f(pixel.x, pixel.y) : cv::Vec2f(-1, -1);
    }
  }
  cv::convertMaps(map, cv::noArray(), pixels, fractions, CV_16SC2);
}

const cv::Mat& StereoDepth::View::of(const cv::Mat& received) {
  cv::remap(received, image, pixels, fractions, cv::INTER_LINEAR);
  return image;
}

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
  } else if (baseline < kShortestBaseline || baseline > kLongestBaseline) {
    std::ostringstream text;
    text.precision(3);
    text << "the camera_infos put the cameras " << baseline
         << " m apart, and lengths are in this unit: P[3] of the right one must be -fx times the baseline in metres";
    doubt = text.str();
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

std::string StereoDepth::setRight(const ImageWithInfo& input, const Features& left, const CameraModel& left_model,
                                  StereoColumns& columns) {
  columns.clear();
  if (!left_model.camera.calibrated()) return "the left camera is not calibrated";
  if (!input.right) {
    return "no image on " + right_topic_ + " has its stamp (within " + secondsText(kStereoTolerance) +
           "); trigger both cameras together, or stamp their images alike";
  }
  if (!input.right_info) return "no camera_info has come on " + right_info_topic_;
  const std::string defect = toGrey(*input.right, columns.right);
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

std::string StereoDepth::fill(const Features& left, const cv::Mat& left_image, const CameraModel& left_model,
                              StereoColumns& columns) {
  const StereoRig rig = *columns.rig;
  columns.rig.reset();
  const Camera &left_camera = left_model.camera, &right_camera = columns.right_camera->camera;
  CameraIntrinsics k = left_camera.intrinsics();
  double infinity = 0;
  cv::Mat left_rows = left_image, right_rows = columns.right;
  if (sharesRows(left_camera, right_camera, rig)) {
    infinity = k.cx - right_camera.intrinsics().cx;
  } else {
    k = rectifiedIntrinsics(left_camera, rig.left);
    left_view_.set(left_camera, rig.left, k);
    right_view_.set(right_camera, rig.right, k);
    left_rows = left_view_.of(left_image);
    right_rows = right_view_.of(columns.right);
  }
  search_.setImages(left_rows, right_rows, infinity);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  columns.depth.assign(left.keypoints.size(), 0);
  columns.right_ray.assign(left.keypoints.size(), {nan, nan});
  points_.clear();
  rays_.clear();
  for (const cv::KeyPoint& keypoint : left.keypoints) {
    const Eigen::Vector2d& ray = rays_.emplace_back(rotated(rig.left, rayOf(left_camera, keypoint.pt)));
    points_.emplace_back(k.fx * ray.x() + k.cx, k.fy * ray.y() + k.cy);
  }
  offsets_.measure(left_rows, right_rows, points_, search_);
  size_t found = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector2d& ray = rays_[i];
    const double below = offsets_.at(points_[i]);
    const std::optional<double> disparity = search_.disparity(points_[i], below);
    if (!disparity || *disparity <= infinity) continue;
    ++found;
    const double difference = (*disparity - infinity) / k.fx;  // of the rays
    columns.right_ray[i] = rotated(rig.right.transpose(), {ray.x() - difference, ray.y() + below / k.fy});
    const double corrected = *disparity - infinity - offsets_.disparityError(points_[i], k);
    if (corrected < kLeastDisparity) continue;
    const Eigen::Vector3d point = rig.left.transpose() * (rig.baseline * k.fx / corrected * ray.homogeneous());
    // R and P of a camera_info may put it behind the camera, or farther than a float can tell.
    if (point.z() > 0 && point.z() <= std::numeric_limits<float>::max()) {
      columns.depth[i] = static_cast<float>(point.z());
    }
  }
  std::string doubt = doubtOfRows(found, infinity);
  if (!doubt.empty()) {
    columns.depth.clear();
    columns.right_ray.clear();
    return doubt;
  }
  columns.rig = rig;
  return std::string();
}

std::string StereoDepth::doubtOfRows(size_t on_rows, double infinity) {
  const auto count = static_cast<double>(points_.size());
  const bool usual = static_cast<double>(on_rows) >= kUsualOnRows * count;
  if (usual && doubt_of_rows_.empty() && images_++ % kLookedAtEvery != 0) return std::string();
  const bool few = static_cast<double>(on_rows) < kFewOnRows * count;
  const size_t stride = 1 + points_.size() / kSearchedBeside;
  if (few && 3 * on_rows < stride * countExchanged(stride, infinity)) {
    return doubt_of_rows_ = "the image on " + right_topic_ +
                            " is that of the left camera: left and right are exchanged; remap images and camera_infos "
                            "of both";
  }
  size_t searched = 0, on = 0;
  std::vector<int> beside;  // rows below, of those that are not on their row
  for (size_t i = 0; i < points_.size(); i += stride, ++searched) {
    const std::optional<int> below = search_.rowsBelow(points_[i], few ? kFarBesideRows : kBesideRows);
    on += below == 0;
    if (below && *below != 0) beside.push_back(*below);
  }
  const double for_each = doubt_of_rows_.empty() ? 1 : kSureOnRows;
  if (few && 2 * on > searched) {
    doubt_of_rows_ =
        "the image on " + right_topic_ +
        " shows the points where the left one does, without disparity: remap left and right to two cameras";
  } else if (beside.size() < (few ? kSureFarBesideRows : kSureBesideRows) ||
             static_cast<double>(on) > for_each * static_cast<double>(beside.size())) {
    doubt_of_rows_.clear();
  } else {
    doubt_of_rows_ = textOfRows(beside);
  }
  return doubt_of_rows_;
}

size_t StereoDepth::countExchanged(size_t stride, double infinity) const {
  const std::unique_ptr<RowSearch> exchanged = search_.exchanged();
  size_t searched = 0, found = 0;
  for (size_t i = 0; i < points_.size(); i += stride, ++searched) {
    found += exchanged->disparity(points_[i]) > kLeastDisparity - infinity;
  }
  return static_cast<double>(found) > kExchanged * static_cast<double>(searched) ? found : 0;
}

std::string StereoDepth::textOfRows(std::vector<int> below) const {
  std::sort(below.begin(), below.end());
  const int median = below[below.size() / 2], spread = below[3 * below.size() / 4] - below[below.size() / 4];
  std::vector<int> away;
  away.reserve(below.size());
  for (const int rows : below) away.push_back(std::abs(rows));
  const std::string rectify = "rectify both images, by the calibration in their camera_info";
  const std::string expose = "expose both cameras at the same time";
  // A wrong rectification moves all rows alike; what moves between two exposures differs with depth and place.
  return "points of the left image lie " + std::to_string(quantilesOf(away).median) +
         " px above or below their rows on " + right_topic_ + ": " +
         (std::abs(median) >= spread ? rectify + "; and " + expose : expose + "; and " + rectify);
}

}  // namespace gms_ransac
