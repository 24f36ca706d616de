// The one reader of image sets: TUM and KITTI folders, lists of image pairs, and ROS bags, with the truth they carry.
#pragma once

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"

namespace gms_ransac {

enum class Rectified;  // camera_info.h

/// The input is missing or malformed. what() is one sentence with the file, and the line number where there is one.
class DatasetError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class DatasetKind { kTum, kKitti, kImagePairs, kBag };

/// The layout of a folder: pairs.txt, rgb.txt, image_0/ or image_l/, or one of KITTI's cameras; absent if it is none.
std::optional<DatasetKind> layoutOf(const std::string& folder);

/// The folder of a KITTI sequence, if `folder` is that of one of its cameras (image_0, image_1, ..., image_l, image_r).
std::optional<std::string> kittiRigOf(const std::string& folder);

/// Last part of a path; of one of KITTI's cameras the last two, "06/image_1".
std::string setName(const std::string& path);

/// One image of the set.
struct DatasetFrame {
  std::string name;  ///< path relative to the folder as listed; "<topic>@<stamp>" in a bag
  double stamp = 0;  ///< seconds
  /// X_world = pose * X_camera, camera optical frame; absent outside the truth.
  std::optional<Eigen::Isometry3d> pose = {};
  std::string depth = {};  ///< depth image nearest in time, relative to the folder; "" when there is none
  double depth_stamp = 0;  ///< seconds; of that depth image
  std::string right = {};  ///< image of the right camera, relative to the folder; "" when there is none
};

/// The second camera of a rectified stereo pair.
struct RightCamera {
  CameraIntrinsics intrinsics;
  double baseline = 0;  ///< metres to the right of the camera of the frames, > 0
};

/// One sample of the true motion, X_world = pose * X_camera.
struct StampedPose {
  double stamp = 0;  ///< seconds
  Eigen::Isometry3d pose;
};

/// Disparity image of the left (reference) view: left (x, y) is right (x - value / scale, y); value 0 is unknown.
struct DisparityFile {
  std::string path;  ///< relative to the folder
  double scale = 1;  ///< grey values per pixel
};

/// Two frames to compare, and what is known of how their pixels correspond apart from the frames' poses.
struct DatasetPair {
  int reference = 0, current = 0;                   ///< indices into Dataset::frames()
  std::optional<Eigen::Matrix3d> homography = {};   ///< current pixel ~ H * reference pixel
  std::optional<Eigen::Matrix3d> fundamental = {};  ///< current^T F reference = 0, pixels
  std::optional<DisparityFile> disparity = {};
};

struct DatasetOptions {
  std::string intrinsics;    ///< as in camera.txt (`parseIntrinsics`); overrides what the set says
  std::string topic;         ///< bags: image topic; "": the only one, or the one of the official TUM or kitti2bag bags
  Rectified rectified = {};  ///< bags: as ~input_is_rectified
};

/// Factory values of the OpenNI driver, the same for every camera and in all official TUM bags: 525, 525, 319.5, 239.5,
/// no distortion.
CameraIntrinsics openNiIntrinsics();

/// Reads an image of a set: CV_8UC1, or CV_8UC3 (BGR) with `colour`. Throws DatasetError when it cannot be read.
using ImageReader = std::function<cv::Mat(int frame, bool colour)>;

class Dataset {
 public:
  /// Recognises a bag by its suffix and a folder by its layout. Throws DatasetError.
  static Dataset open(const std::string& path, const DatasetOptions& options = {});

  DatasetKind kind() const { return kind_; }
  const std::string& path() const { return path_; }
  std::string name() const { return setName(path_); }
  const std::vector<DatasetFrame>& frames() const { return frames_; }
  /// The truth of a folder as it was recorded, at its own rate; empty for bags and image pairs.
  const std::vector<StampedPose>& trajectory() const { return trajectory_; }
  /// Between the two samples of the trajectory around a time; absent outside it and across long holes.
  std::optional<Eigen::Isometry3d> truthAt(double stamp) const;
  /// Absent when the set says nothing and none were given: then only uncalibrated models apply.
  const std::optional<CameraIntrinsics>& intrinsics() const { return intrinsics_; }
  /// Absent if the set has no second camera, or no place of it.
  const std::optional<RightCamera>& rightCamera() const { return right_camera_; }
  /// Names the calibration in use and its source.
  std::string calibrationText() const;
  /// A sentence for each file of the set that does not fit its images.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Every `stride`-th pair of frames that are `gap` apart (gap, stride >= 1). A pair list ignores the gap.
  std::vector<DatasetPair> pairs(int gap, int stride) const;
  /// At most `count` pairs, spread evenly over the set.
  std::vector<DatasetPair> spreadPairs(int gap, int count) const;

  /// Seconds; not set in a list of image pairs, which has none.
  std::optional<double> stamp(int frame) const;
  cv::Mat image(int frame, bool colour = false) const { return read_(frame, colour); }
  /// CV_32FC1, metres along the optical axis, 0 where unknown; empty when the frame has no depth.
  cv::Mat depth(int frame) const;
  /// CV_8UC1; empty when the frame has no image of the right camera.
  cv::Mat right(int frame) const;
  /// CV_32FC1, pixels, 0 where unknown; empty when the pair has no disparity.
  cv::Mat disparity(const DatasetPair& pair) const;

 private:
  // One reader for each layout, in a file of its own.
  void readTum();
  void readKitti();
  void readImagePairs();
  void readBag(const DatasetOptions& options);

  DatasetKind kind_ = DatasetKind::kTum;
  std::string path_;
  std::vector<DatasetFrame> frames_;
  std::vector<StampedPose> trajectory_;
  std::vector<DatasetPair> listed_pairs_;
  std::optional<CameraIntrinsics> intrinsics_;
  std::optional<RightCamera> right_camera_;
  std::string intrinsics_source_;  ///< file, topic or option, and which of its matrices
  std::string advice_;             ///< what to give where the calibration was guessed, in brackets; empty: nothing
  std::vector<std::string> notes_;
  ImageReader read_;
};

}  // namespace gms_ransac
