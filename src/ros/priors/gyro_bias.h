// The bias of a gyro, estimated while the images show no rotation.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "priors/rotation_comparison.h"

namespace gms_ransac {

/// A Kalman filter on three numbers that drift slowly and are known equally well.
class GyroBias {
 public:
  /// `seen`: in the axes of the gyro, its prior without any bias taken off. Used if the images show no rotation: then
  /// neither extrinsics nor stamps matter. Replaces one with the same start, as while the reference is held.
  void add(const ComparedRotation& seen);

  const Eigen::Vector3d& bias() const { return with_last_.bias; }  ///< rad/s
  double variance() const { return with_last_.variance; }          ///< of each axis, (rad/s)^2
  bool known() const { return last_from_.has_value(); }

  static constexpr double kStillRate = 0.01;  ///< rad/s below which the images show no rotation: half a degree a second
  static constexpr double kFirstSigma = 0.05;  ///< rad/s, before anything is seen: three degrees a second, a cheap MEMS
                                               ///< gyro's zero-rate offset
  static constexpr double kDrift = 1e-4;       ///< rad/s a square root of a second

 private:
  struct State {
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();
    double variance = kFirstSigma * kFirstSigma, stamp = 0;
  };
  State before_last_, with_last_;
  std::optional<double> last_from_;  ///< start of the last one that was used
};

}  // namespace gms_ransac
