// The right image of a stereo pair -> depth of the left image's keypoints, and where the right camera sees them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <sensor_msgs/CameraInfo.h>
#include <Eigen/Core>

#include "gms_ransac/features.h"
#include "input/camera_model.h"
#include "input/image_conversion.h"
#include "input/image_with_info.h"
#include "matching/row_offsets.h"
#include "matching/row_search.h"

namespace gms_ransac {

/// How two cameras stand to each other, by R and P of their camera_infos (sensor_msgs/CameraInfo, stereo pairs).
struct StereoRig {
  /// Rays of the camera that took the image -> rays of the rectified camera; identity for rectified images.
  Eigen::Matrix3d left = Eigen::Matrix3d::Identity(), right = Eigen::Matrix3d::Identity();
  double baseline = 0;  ///< metres, the right camera's x in the left one's rectified frame
  std::string problem;  ///< why there is no such thing, as a sentence; empty when there is
  std::string doubt;    ///< why the baseline cannot be in metres, and what to do; empty: no reason

  StereoRig(const CameraModel& left_model, const sensor_msgs::CameraInfo& left_info, const CameraModel& right_model,
            const sensor_msgs::CameraInfo& right_info);
};

/// A ray, x and y at depth 1, in axes that it is rotated into.
Eigen::Vector2d rotated(const Eigen::Matrix3d& R, const Eigen::Vector2d& ray);

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
  std::string setRight(const ImageWithInfo& input, const Features& left, const CameraModel& left_model,
                       StereoColumns& columns);
  /// After `setRight`: finds the keypoints on their rows of the right image and fills the columns. Returns why it does
  /// not, empty when it does.
  std::string fill(const Features& left, const cv::Mat& left_image, const CameraModel& left_model,
                   StereoColumns& columns);

 private:
  /// An image as a rectified camera would take it.
  struct View {
    Camera camera;
    Eigen::Matrix3d turn;
    cv::Mat pixels, fractions;  ///< where its pixels lie in the received image, as cv::remap reads them
    cv::Mat image;
    void set(const Camera& of, const Eigen::Matrix3d& to_rectified, const CameraIntrinsics& k);
    const cv::Mat& of(const cv::Mat& received);
  };
  /// Returns why keypoints are not found on their rows, if more are found on other rows; keeps it until they are.
  std::string doubtOfRows(size_t on_rows, double infinity);
  /// Every stride-th keypoint that is found as if left and right were exchanged; 0 where chance may find as many.
  size_t countExchanged(size_t stride, double infinity) const;
  /// Names the reason for rows that are off, by the rows by which points are lower on the right.
  std::string textOfRows(std::vector<int> below) const;

  const std::string right_topic_, right_info_topic_;
  CameraModelSource camera_source_;
  View left_view_, right_view_;
  RowSearch search_;
  RowOffsets offsets_;
  std::vector<cv::Point2f> points_;    ///< the keypoints in the rectified left image
  std::vector<Eigen::Vector2d> rays_;  ///< of them, in the rectified left camera
  std::string doubt_of_rows_;          ///< of the last image that was looked at; empty: none
  int images_ = 0;                     ///< with their points on their rows
};

}  // namespace gms_ransac
