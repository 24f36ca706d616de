// A gms_ransac/Correspondences message as matrices, without a copy. Header-only, without ROS headers.
#pragma once

#include <cstdint>
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
  /// Rays of the points on the plane z = 1: N x 1 CV_32FC2. Points that are not rectified need `distortion_model` and
  /// `D` of the images' camera_info. Throws std::invalid_argument without them or without K.
  cv::Mat normalized(const cv::Mat& points, const std::string& distortion_model = "",
                     const std::vector<double>& D = {}) const {
    if (!calibrated()) throw std::invalid_argument("Correspondences: the camera is not calibrated (K is zero)");
    if (!isRectified() && D.empty()) {
      throw std::invalid_argument(
          "Correspondences: the points are pixels of a distorted image; give the distortion of its camera_info, or "
          "rectified images to the node");
    }
    for (const char* spheres : {"omnidirectional", "mei", "omni", "omni-radtan", "double_sphere", "ds"}) {
      if (isRectified() || distortion_model != spheres) continue;
      throw std::invalid_argument("Correspondences: OpenCV has no inverse of " + distortion_model +
                                  "; use rayOf (camera.h)");
    }
    const bool fisheye = distortion_model == "equidistant" || distortion_model == "fisheye";
    if (!isRectified()) requireCoefficients(fisheye, D.size());
    cv::Mat rays;
    if (points.empty()) return rays;
    const cv::Matx33d K(&message_.K[0]);
    if (!isRectified() && fisheye) {
      cv::fisheye::undistortPoints(points, rays, K, D);
    } else {
      // The default of five iterations leaves pixels of error in the corners of strongly distorted images.
      const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10);
      cv::undistortPoints(points, rays, K, isRectified() ? std::vector<double>() : D, cv::noArray(), cv::noArray(),
                          until);
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
  /// OpenCV would throw an assertion of its own.
  static void requireCoefficients(bool fisheye, size_t n) {
    if (n == 4 || (!fisheye && (n == 5 || n == 8 || n == 12 || n == 14))) return;
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
