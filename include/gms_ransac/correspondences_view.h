// A gms_ransac/Correspondences message as matrices, without a copy. Header-only, without ROS headers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace gms_ransac {

/// Reads the columns of a message in place: the message must outlive the view. Usage: `const CorrespondencesView
/// view(*message); cv::Mat points = view.currentPoints();`
template <typename Message>
class CorrespondencesView {
 public:
  using Points = Eigen::Map<const Eigen::Matrix<float, 2, Eigen::Dynamic>>;
  using Column = Eigen::Map<const Eigen::VectorXf>;

  /// Checks the lengths of all columns once. Throws std::invalid_argument naming the first that does not fit.
  explicit CorrespondencesView(const Message& message) : message_(message) {
    const size_t n = message.confidence.size();
    require("reference_points", message.reference_points.size(), 2 * n);
    require("current_points", message.current_points.size(), 2 * n);
    require("distance", message.distance.size(), n);
    require("track_id", message.track_id.size(), n);
    require("track_length", message.track_length.size(), n);
    require("probability", message.probability.size(), n);
    require("reference_sigma", message.reference_sigma.size(), n);
    require("current_sigma", message.current_sigma.size(), n);
    if (!message.stage.empty()) require("stage", message.stage.size(), n);
  }
  explicit CorrespondencesView(Message&&) = delete;  // the view would outlive it

  int size() const { return static_cast<int>(message_.confidence.size()); }
  /// True for matches that both filter and robust estimation kept; all are when the message has no stage column.
  bool isInlier(int i) const { return message_.stage.empty() || message_.stage[i] == Message::STAGE_INLIER; }

  /// N x 1 CV_32FC2, pixels.
  cv::Mat referencePoints() const { return asMat(message_.reference_points); }
  cv::Mat currentPoints() const { return asMat(message_.current_points); }
  /// 2 x N, pixels.
  Points reference() const { return {message_.reference_points.data(), 2, size()}; }
  Points current() const { return {message_.current_points.data(), 2, size()}; }
  /// N values in 0..1: how much support a match has around it, and how probably it is right.
  Column confidence() const { return {message_.confidence.data(), size()}; }
  Column probability() const { return {message_.probability.data(), size()}; }
  /// N standard deviations of either coordinate, pixels; 0: not known.
  Column referenceSigma() const { return {message_.reference_sigma.data(), size()}; }
  Column currentSigma() const { return {message_.current_sigma.data(), size()}; }

  /// False: the points are pixels of the distorted image, which K alone does not describe.
  bool isRectified() const { return message_.pixel_space == Message::PIXELS_RECTIFIED; }
  /// Rays (x, y, 1) of rectified points: x and y as N x 1 CV_32FC2, the type of `points`. Throws std::invalid_argument
  /// if the points are distorted or the camera is not calibrated.
  cv::Mat normalized(const cv::Mat& points) const { return normalized(points, NoInfo()); }
  /// The same of points that may be distorted, by `distortion_model` and `D` of the camera_info of the images. Throws
  /// std::invalid_argument also for another model than plumb_bob, rational_polynomial and equidistant, and for a wrong
  /// number of coefficients.
  template <typename CameraInfo>
  cv::Mat normalized(const cv::Mat& points, const CameraInfo& info) const {
    if (!calibrated()) throw std::invalid_argument("Correspondences: the camera is not calibrated (K is zero)");
    cv::Mat rays;
    const cv::Matx33d K(&message_.K[0]);
    // The default of five iterations leaves pixels of error in the corners of strongly distorted images.
    const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10);
    if (isRectified()) {
      if (!points.empty()) cv::undistortPoints(points, rays, K, cv::noArray(), cv::noArray(), cv::noArray(), until);
      return rays;
    }
    std::vector<double> D(info.D.begin(), info.D.end());
    const bool fisheye = requireLens(info.distortion_model, D);
    if (points.empty()) return rays;
    if (fisheye) {
      cv::fisheye::undistortPoints(points, rays, K, D);
    } else {
      cv::undistortPoints(points, rays, K, D, cv::noArray(), cv::noArray(), until);
    }
    return rays;
  }
  bool calibrated() const { return message_.K[0] > 0 && message_.K[4] > 0; }
  Eigen::Matrix3d K() const { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&message_.K[0]); }
  /// X_reference = pose * X_current, where the message says pose_valid. t is zero where unknown; its length is in
  /// metres with metric_scale, else 1 or that of `~scale: propagate`.
  Eigen::Isometry3d currentInReference() const {
    const auto& pose = message_.current_in_reference.pose;
    const auto& q = pose.orientation;
    Eigen::Isometry3d result(Eigen::Quaterniond(q.w, q.x, q.y, q.z));
    result.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
    return result;
  }

 private:
  static void require(const char* column, size_t length, size_t expected) {
    if (length == expected) return;
    throw std::invalid_argument("Correspondences: " + std::string(column) + " has " + std::to_string(length) +
                                " entries, but " + std::to_string(expected) + " belong to this many confidences");
  }
  /// In the place of a camera_info.
  struct NoInfo {
    std::string distortion_model;
    std::vector<double> D;
  };
  /// Returns true for a fisheye lens. Cuts zeros behind its coefficients, which OpenCV would not take.
  static bool requireLens(const std::string& model, std::vector<double>& D) {
    if (D.empty()) {
      throw std::invalid_argument(
          "Correspondences: the points are pixels of a distorted image; give its camera_info, or rectified images to "
          "the "
          "node");
    }
    const auto is = [&model](std::initializer_list<const char*> names) {
      return std::find(names.begin(), names.end(), model) != names.end();
    };
    if (is({"omnidirectional", "mei", "omni", "omni-radtan", "double_sphere", "ds"})) {
      throw std::invalid_argument("Correspondences: OpenCV has no inverse of " + model + "; use rayOf (camera.h)");
    }
    const bool fisheye = is({"equidistant", "fisheye"});
    if (!fisheye && !is({"", "plumb_bob", "radtan", "rational_polynomial"})) {
      throw std::invalid_argument("Correspondences: '" + model +
                                  "' is no known distortion model; it must be plumb_bob, rational_polynomial or "
                                  "equidistant");
    }
    while (fisheye && D.size() > 4 && D.back() == 0) D.pop_back();
    const size_t n = D.size();
    if (n == 4 || (!fisheye && (n == 5 || n == 8 || n == 12 || n == 14))) return fisheye;
    throw std::invalid_argument("Correspondences: " + std::to_string(n) + " distortion coefficients; " +
                                (fisheye ? "a fisheye lens has 4" : "there must be 4, 5, 8, 12 or 14"));
  }
  template <typename Vector>
  cv::Mat asMat(const Vector& interleaved) const {
    return cv::Mat(size(), 1, CV_32FC2, const_cast<float*>(interleaved.data()));
  }

  const Message& message_;
};

}  // namespace gms_ransac
