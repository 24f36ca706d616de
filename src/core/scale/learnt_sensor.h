// The errors that calibration has left in the disparities of two cameras, learnt over a stream.
#pragma once

#include <Eigen/Core>

#include "gms_ransac/stream_constant.h"
#include "scale/joint_refinement.h"

namespace gms_ransac {

/// Pixels to be added to a disparity, and their growth with x = 1, y = 1 and x^2 + y^2 = 1 (JointMotion::sensor).
class LearntRig {
 public:
  /// `pixel`: of disparity, 1/m.
  SensorPrior prior(double pixel) const;
  void add(const SensorEvidence& pair, double pixel);

  Eigen::Vector4d mean() const;
  Eigen::Vector4d deviation() const;  ///< standard deviation of each
  /// True once one of the numbers is surely not zero, and large enough to matter.
  bool isOff() const;

 private:
  StreamConstant<4> constant_{10, 0.98};
};

}  // namespace gms_ransac
