// A rendered scene: textured rectangles ray-cast along a smooth camera path, with exact poses, depth and
// correspondences. It is the input that is always at hand, for tests, benchmarks and demonstrations.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "scenes/scene_imu.h"
#include "scenes/scene_layout.h"
#include "scenes/scene_trajectory.h"

namespace gms_ransac {

class Distortion;

struct SceneOptions {
  std::string scene = "room";      ///< "room" (a hall, camera on a circle) or "street" (camera drives along it)
  cv::Size size = {640, 480};      ///< pixels
  double focal_length = 0;         ///< pixels; 0: 525 per 640 pixels of width, as the OpenNI cameras
  std::vector<double> distortion;  ///< plumb_bob k1 k2 p1 p2 [k3]; empty: none
  double step = -1;                ///< camera path per frame, metres; negative: 0.08 in the room, 0.3 in the street
  double turn = 0;                 ///< additional heading per frame, degrees (with step 0: pure rotation)
  double sway = 1;                 ///< factor on the hand's slow translation and rotation; 0: none
  double offset = 0;               ///< metres that the camera is moved to its right: the right one of a stereo pair
  double rate = 30;                ///< frames per second
  bool colour = false;             ///< BGR instead of grey images
  double noise = 2;                ///< standard deviation of the image noise, grey levels
  double blur = 0.5;               ///< standard deviation of the lens blur, pixels
  uint64_t seed = 0;               ///< of textures, furniture and noise
  ImuOptions imu;                  ///< an IMU on the camera
  /// Path in place of the scene's own, without step, turn and sway. It is moved into the scene, whose room becomes a
  /// hall that holds it. The first frame is one frame after its start.
  std::shared_ptr<const Trajectory> trajectory;

  // Difficulties. Poses are those of the middle row in the middle of the exposure.
  int movers = 0;         ///< boards that keep before the camera and sway from side to side by themselves
  double repetition = 0;  ///< every texture repeats itself after so many metres; 0: not
  double readout = 0;     ///< rolling shutter: share of the time between frames; 0: global shutter
  double exposure = 0;    ///< the shutter is open for this share of the time between frames; 0: an instant
  double brightness = 1;  ///< factor on the image before its noise

  /// Throws std::invalid_argument with a sentence that names the field, its value and its range.
  void validate() const;
};

struct RenderedFrame {
  double stamp = 0;               ///< seconds; frame 0 has kSceneStart
  cv::Mat image;                  ///< CV_8UC1 or CV_8UC3 (BGR)
  cv::Mat_<float> depth;          ///< metres along the optical axis, at pixel centres; 0 where nothing is hit
  Eigen::Isometry3d camera_pose;  ///< X_world = camera_pose * X_camera; optical frame: x right, y down, z forward
};

constexpr double kSceneStart = 1.6e9;  ///< a stamp that no ROS tool takes for "not set"

/// A texture is painted when a frame first shows it. Frames are independent of each other.
class Scene {
 public:
  explicit Scene(const SceneOptions& options);  ///< validates

  const SceneOptions& options() const { return options_; }
  const CameraIntrinsics& intrinsics() const { return intrinsics_; }
  /// Frames before the path ends: a very large number in the room, whose path is closed.
  int frameCount() const;
  double stamp(int index) const { return kSceneStart + index / options_.rate; }
  /// Throws std::invalid_argument where the camera meets a surface before frame `frames`.
  void requireFreePath(int frames) const;
  /// Samples of the IMU from one frame before the first to one after the last; the same for both cameras of a stereo
  /// pair.
  std::vector<ImuSample> imuSamples(int frames) const;

  /// Frame `index` >= 0; the same options and index give the same frame. Throws std::invalid_argument past the end.
  RenderedFrame render(int index) const;
  /// X_world = pose(index) * X_camera.
  Eigen::Isometry3d pose(int index) const;

  /// Depth along the optical axis seen at `pixel` of frame `index`; 0 when the ray leaves the scene.
  double depth(int index, const cv::Point2d& pixel) const;
  /// Where the surface point seen at `pixel` of frame `reference` appears in frame `current`; false when it is
  /// hidden there, outside the image or behind the camera. Exact up to rounding: no image is involved. Global
  /// shutter: ignores `readout`.
  bool correspondence(int reference, const cv::Point2d& pixel, int current, cv::Point2d& position) const;
  /// Pixel of a point in the camera frame, distortion included.
  cv::Point2d project(const Eigen::Vector3d& point) const;

 private:
  /// Rays (x, y, 1) of the camera frame on a regular grid of image positions.
  struct RayGrid {
    cv::Mat_<cv::Vec2f> rays;
    std::vector<cv::Vec2f> y_range;  ///< smallest and largest y of each row
  };
  RayGrid makeRays(int samples_per_pixel_side) const;
  /// The camera and all surfaces at one time.
  struct View {
    Eigen::Isometry3d pose;
    std::vector<Surface> surfaces;
  };
  /// Where a ray meets a surface first.
  struct Hit {
    double depth = 0;  ///< in lengths of the ray, whose z is 1 along the optical axis; 0: nowhere
    size_t surface = 0;
    double u = 0, v = 0;  ///< on that surface, metres
  };
  Eigen::Isometry3d pathAt(double time) const;  ///< in frames; without the offset
  Eigen::Isometry3d poseAt(double time) const;  ///< in frames
  View viewAt(double time) const;
  Eigen::Vector2d ray(const cv::Point2d& pixel) const;
  static Hit cast(const std::vector<Surface>& surfaces, const Eigen::Vector3d& from, const Eigen::Vector3d& direction);
  static Hit cast(const View& view, const Eigen::Vector2d& ray);
  /// Depth at the grid's rays and, where `shading` is given, its grey levels or colours.
  void castGrid(double time, const RayGrid& grid, cv::Mat_<float>* depth, cv::Mat* shading) const;
  /// The image's samples, averaged over the exposure.
  cv::Mat exposed(int index) const;
  void shade(const View& view, const cv::Vec2f& ray, int surface, const cv::Vec3f& hit, uint8_t* out) const;

  SceneOptions options_;
  CameraIntrinsics intrinsics_;
  std::shared_ptr<const Distortion> lens_;  ///< null: no distortion
  Eigen::Isometry3d trajectory_in_scene_ = Eigen::Isometry3d::Identity();
  std::vector<Surface> surfaces_;
  std::deque<Texture> textures_;  ///< one for each surface
  RayGrid samples_, centres_;     ///< of the image samples and of the pixel centres
};

}  // namespace gms_ransac
