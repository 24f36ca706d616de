// The right image of a stereo pair -> depth of the left image's keypoints, and where the right camera sees them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <sensor_msgs/CameraInfo.h>
#include <Eigen/Core>

#include "gms_ransac/match_filter.h"
#include "input/camera_model.h"
#include "input/image_conversion.h"
#include "input/image_with_info.h"
#include "matching/stereo_matcher.h"

namespace gms_ransac {

/// How two cameras stand to each other, by R and P of their camera_infos (sensor_msgs/CameraInfo, stereo pairs).
struct StereoRig {
  /// Rays of the camera that took the image -> rays of the rectified camera; identity for rectified images.
  Eigen::Matrix3d left = Eigen::Matrix3d::Identity(), right = Eigen::Matrix3d::Identity();
  double baseline = 0;  ///< metres, the right camera's x in the left one's rectified frame
  std::string problem;  ///< why there is no such thing, as a sentence; empty when there is

  StereoRig(const CameraModel& left_model, const sensor_msgs::CameraInfo& left_info, const CameraModel& right_model,
            const sensor_msgs::CameraInfo& right_info);
};

/// The right image, and one entry per keypoint of the left image where its depth was wanted.
struct StereoColumns {
  std::vector<float> depth;                ///< metres along the left camera's optical axis; 0: not known
  std::vector<Eigen::Vector2d> right_ray;  ///< x, y at depth 1 in the right camera; NaN: it does not show the point
  cv::Mat right;                           ///< CV_8UC1; the received image's memory where that is grey
  std::shared_ptr<const CameraModel> right_camera;
  std::optional<StereoRig> rig;  ///< none: the right image is unusable
  void clear();
};

class StereoDepth {
 public:
  StereoDepth(const Parameters& parameters, const std::string& right_topic, const std::string& right_info_topic);

  /// Sets the right image, its camera and the rig. Returns why they are unusable, empty when they are not.
  std::string take(const ImageWithInfo& input, const Features& left, const CameraModel& left_model,
                   StereoColumns& columns);
  /// After `take`: extracts the right image as the left one was and fills the columns. Returns why it does not, empty
  /// when it does.
  std::string fill(const Features& left, const CameraModel& left_model, MatchFilter& filter, StereoColumns& columns);
  /// Seconds that the last extraction of the right image took.
  double detectSeconds() const { return right_.detect_seconds; }

 private:
  /// Returns why few keypoints have a match on their row, if many have one on other rows.
  std::string doubtOfRows(const Features& left, double focal_length) const;

  const std::string right_topic_, right_info_topic_;
  ImageConverter converter_;
  CameraModelSource camera_source_;
  Frame right_;
  RectifiedRays left_rays_, right_rays_;
  std::vector<StereoMatch> matches_;
};

}  // namespace gms_ransac
