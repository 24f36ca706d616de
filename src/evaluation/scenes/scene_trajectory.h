// The motion of a camera from a file of poses: a smooth curve, which images and an IMU are rendered along.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "datasets/dataset.h"

namespace gms_ransac {

struct TrajectoryOptions {
  std::string file;         ///< TUM's or KITTI's text or EuRoC's CSV, recognised by its first line
  double pose_rate = 10;    ///< poses per second of KITTI's text, which has no times
  double from = 0;          ///< seconds after the first pose
  double duration = 0;      ///< seconds; 0: to the end
  double scale = 1;         ///< factor on the positions
  std::optional<bool> imu;  ///< poses are those of an IMU; absent: of the IMU in EuRoC's CSV, else of the camera
  std::optional<Eigen::Isometry3d> camera_in_imu;  ///< X_imu = camera_in_imu * X_camera

  /// Throws std::invalid_argument with a sentence that names the field, its value and its range.
  void validate() const;
};

/// Poses of the camera in a world whose z points up, the first one at the origin at time 0. The world of KITTI's text,
/// the first camera, is rotated; those of the other files must have z up. Throws DatasetError with the file and the
/// line.
std::vector<StampedPose> readTrajectory(const TrajectoryOptions& options);

/// A uniform B-spline of degree five close to the poses: acceleration and angular acceleration are smooth.
/// Position and unit quaternion are fitted by least squares with third differences as penalty (Eilers & Marx 1996,
/// P-splines), the quaternion is normalised afterwards.
class Trajectory {
 public:
  /// At least two poses whose times increase; at most 90 degrees from each to the next.
  explicit Trajectory(const std::vector<StampedPose>& poses);

  double begin() const { return begin_; }  ///< seconds, as end()
  double end() const { return begin_ + spacing_ * (static_cast<double>(points_.cols()) - kDegree); }
  /// X_world = pose * X_camera at a time between begin() and end().
  Eigen::Isometry3d pose(double seconds) const;

 private:
  static constexpr int kDegree = 5;
  using Basis = Eigen::Matrix<double, kDegree + 1, 1>;

  /// Values at a time of the basis functions that are not 0; `first` is the number of the first.
  Basis basis(double seconds, int& first) const;

  double begin_, spacing_;                           ///< of the knots, seconds
  Eigen::Matrix<double, 7, Eigen::Dynamic> points_;  ///< control points: x y z qx qy qz qw
};

/// X_scene = place * X_world such that the trajectory lies in the middle of a hall, a metre above the floor or more.
Eigen::Isometry3d placeInHall(const Trajectory& trajectory);
/// The same for a start in the street, towards the farthest place that the camera reaches.
Eigen::Isometry3d placeInStreet(const Trajectory& trajectory, const Eigen::Vector3d& start);
/// Places along the trajectory, close to each other.
std::vector<Eigen::Vector3d> placesAlong(const Trajectory& trajectory, const Eigen::Isometry3d& place);

}  // namespace gms_ransac
