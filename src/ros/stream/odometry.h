// Answers -> the pose of the camera in the odometry frame: relative poses chained, with covariance; and the same for a
// base frame that carries the camera. Knows no topic.
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "frames.h"
#include "gms_ransac/relative_pose.h"
#include "stream/pair_pose.h"
#include "stream/shared_errors.h"

namespace gms_ransac {

struct Parameters;
struct ProcessedFrame;

/// Pose and velocity of a moving frame. Order of the covariances: x y z, then rotation about x y z; perturbations are
/// additive for translations and on the left for rotations, in the axes the quantity is expressed in.
struct OdometryEstimate {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< moving frame in the odometry frame
  Matrix6d pose_covariance = Matrix6d::Zero();
  Vector6d twist = Vector6d::Zero();  ///< linear, angular; in the moving frame; per second
  Matrix6d twist_covariance = Matrix6d::Identity() * kLargestVariance;  ///< unknown before the first motion
};

/// Position and linear velocity are not in metres: a filter that fuses them must not move by them, not even when it
/// does so for minutes. robot_localization warns of so large a variance.
constexpr double kNoLengthVariance = 1e6;
/// Velocities stay where they are zero, `at_rest`.
void forgetLength(bool at_rest, OdometryEstimate& estimate);

/// The motion since an earlier image than the reference, the key frame.
struct MotionSinceKey {
  RelativePose current_in_key;
  bool key_is_reference;  ///< of this pair; else it is that of the last motion
};

/// The motion of one pair of images. Covariances are of what no other pair shares; `shared` has the rest.
struct PairMotion {
  RelativePose current_in_reference;
  double seconds = 0;             ///< between the two images, > 0
  bool translation_known = true;  ///< false: t is zero, because the pair does not tell it
  bool reference_held = false;    ///< the next pair starts from the same reference
  double parallax_px = 0;         ///< median of the inliers; 0: not known
  bool after_loss = false;        ///< much may have happened between the two images: no measure of usual motions
  bool at_rest = false;           ///< stands still between others: no measure of usual motions
  std::optional<MotionSinceKey> since_key = {};  ///< where the place comes from, if known
  SharedErrors shared = SharedErrors::Zero();
  double guessed_length = 0;  ///< of a translation whose direction alone is known; 0: the length is known, too
};

/// A value: a copy goes on from the same place. Own errors of the pairs add up in variance, shared ones in size. An
/// unknown motion adds its usual size to the covariance. Consecutive unknown motions may have the same direction: their
/// sizes add up, not their variances.
class MotionIntegrator {
 public:
  /// `first_step`: length of a translation, in its unit, as long as none is known.
  explicit MotionIntegrator(double first_step = 1) : first_step_(first_step) {}

  std::optional<double> stamp;  ///< of the image that this is the place of, seconds; none: of none yet

  /// The odometry frame is the camera at the next image.
  void restart();
  /// The motion of so many seconds was missed: it is taken to be about as fast as the last one known, in any direction.
  void lose(double seconds);
  /// Without parallax as much as usual the camera has moved less than it usually does: a translation that is not known
  /// is taken to be as much shorter than the last known one.
  void add(const PairMotion& motion);

  /// The camera is there at the last image; it replaces all that was known.
  void set(const Eigen::Isometry3d& pose, const Matrix6d& covariance);

  /// Length of the last known translation, in its unit; 0: none is known.
  double step() const { return known_.step; }
  /// Seconds that it took; 0: none is known.
  double usualInterval() const { return known_.step_seconds; }
  /// Length of a translation of this duration at the last known speed; 0: none is known.
  double stepOf(double seconds) const { return known_.step > 0 ? known_.step * seconds / known_.step_seconds : 0; }
  /// Pose of the camera at the last image added, with covariances that are bounded as those of a pair are.
  OdometryEstimate camera() const { return base(Eigen::Isometry3d::Identity()); }
  /// The same of a base frame on the same rigid body. The odometry frame is then the base frame at the first image.
  OdometryEstimate base(const Eigen::Isometry3d& camera_in_base) const;

 private:
  /// The last known translation and rotation.
  struct Usual {
    double step = 0, step_seconds = 0, parallax_px = 0;
    double turn = 0, turn_seconds = 0;  ///< radians
  };
  /// An estimate with the covariance of the own errors of the pairs, the shared errors, and what was missed since
  /// motion was last known.
  struct Place {
    OdometryEstimate estimate;
    SharedErrors shared = SharedErrors::Zero();
    double missed_step = 0, missed_turn = 0;
  };
  /// Size of a translation with this parallax that is not known; parallax 0: that is not known either.
  double usualStep(double parallax_px) const;
  /// Puts the current place one motion beyond another one.
  void chain(const Place& from, const RelativePose& motion);
  void setTwist(const PairMotion& motion);

  double first_step_ = 1;
  Place key_, reference_, current_;
  Usual known_;
};

/// Moves `place` on to the image of the answer, and says in the answer whether that is known.
void integrate(const Parameters& parameters, MotionIntegrator& place, ProcessedFrame& answer);

}  // namespace gms_ransac
