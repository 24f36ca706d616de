// The bias of a gyro, learnt while the images say that nothing turns. Knows no topic.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace gms_ransac {

/// What gyro and images say of the same interval, in the axes of the gyro.
struct StillObservation {
  double from = 0, to = 0;                               ///< seconds
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();        ///< rotation vector, without any bias taken off
  Eigen::Vector3d visual = Eigen::Vector3d::Zero();      ///< the same of the images
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of their difference, rad^2
};

/// A Kalman filter on three numbers that drift slowly.
class GyroBias {
 public:
  GyroBias() { reset(); }
  void reset();
  /// Uses the observation if the images say that nothing turns: then neither extrinsics nor stamps have a part in it.
  /// Of observations with one start, as while the reference is held, the last alone counts.
  void add(const StillObservation& observation);

  const Eigen::Vector3d& bias() const { return with_pending_.bias; }              ///< rad/s
  const Eigen::Matrix3d& covariance() const { return with_pending_.covariance; }  ///< (rad/s)^2
  bool known() const { return observations_ > 0; }
  int observations() const { return observations_; }

  static constexpr double kStillRate = 0.01;   ///< rad/s of the images that is no turning, half a degree a second
  static constexpr double kFirstSigma = 0.05;  ///< rad/s, before anything is seen: three degrees a second, a cheap MEMS
                                               ///< gyro's zero-rate offset
  static constexpr double kDrift = 1e-4;       ///< rad/s a square root of a second

 private:
  struct State {
    Eigen::Vector3d bias;
    Eigen::Matrix3d covariance;
    double stamp;
  };
  static State updated(State state, const StillObservation& observation);

  State settled_, with_pending_;
  std::optional<StillObservation> pending_;
  int observations_ = 0;
};

}  // namespace gms_ransac
