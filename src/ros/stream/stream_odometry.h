// Odometry of images in memory by the classes of the node, for offline programs: shows nothing of ROS.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_filter_options.h"
#include "gms_ransac/relative_pose.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

struct OdometryOptions {
  MatchFilterOptions core;
  ScaleMode scale = ScaleMode::kPropagate;  ///< as ~scale; without use if there is a second camera
  double camera_height = 0;                 ///< metres; with ScaleMode::kGround
  CameraIntrinsics camera;
  std::optional<CameraIntrinsics> right;   ///< second camera, of rectified images
  double baseline = 0;                     ///< metres from the camera to the right one
  std::optional<double> systematic_sigma;  ///< as ~systematic_sigma; not set: its default
};

struct OdometryImages {
  double stamp = 0;        ///< seconds, later than that of the images before
  cv::Mat image, right;    ///< CV_8UC1
  cv::Mat depth;           ///< CV_32FC1 metres, 0 where unknown; may be empty
  double depth_stamp = 0;  ///< seconds; two images may be nearest to the same depth image
};

/// A part of the way that ends with an image: the motion since an earlier image, as ~odom has it if ~set_pose sent that
/// image's pose without an error.
struct OdometryPart {
  double from_stamp = 0;
  double length = 0;    ///< the part is the first one that is as long
  bool metres = false;  ///< unit of `length`: metres of the way, or seconds
  Eigen::Isometry3d motion;
  Eigen::Matrix<double, 6, 6> covariance;
};

/// Velocity in the camera frame: linear, angular.
struct OdometryTwist {
  Eigen::Matrix<double, 6, 1> velocity;
  Eigen::Matrix<double, 6, 6> covariance;
};

struct OdometryAnswer {
  std::string text;    ///< status and reasons, as ~stats has them
  bool known = false;  ///< the motion up to this image is known; else `pose` is the last one known
  bool metric = false;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< X_first = pose * X_this, camera optical frames
  std::optional<double> reference_stamp;  ///< of the image that `pair` starts from; none: no valid pair
  RelativePose pair;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< of `pose`
  std::optional<OdometryTwist> twist;                                            ///< none: ~twist is silent
  std::vector<OdometryPart> parts;  ///< 1, 10 and 50 metres or seconds long; of metres only where they are known
  double seconds = 0;               ///< of processor time, conversion to publishable answer
};

/// Answers as the node does. One object is one stream.
class StreamOdometry {
 public:
  /// Throws std::invalid_argument if options contradict each other.
  explicit StreamOdometry(const OdometryOptions& options);
  ~StreamOdometry();
  OdometryAnswer add(const OdometryImages& images);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace gms_ransac
