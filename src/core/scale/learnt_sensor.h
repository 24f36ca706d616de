// Errors of the inverse depths of a sensor that its calibration has left, learnt over a stream.
#pragma once

#include <Eigen/Core>

#include "gms_ransac/stream_constant.h"
#include "scale/joint_refinement.h"

namespace gms_ransac {

/// JointMotion::sensor of a stream. `pixel`: of the disparity of two cameras, 1/m.
class LearntSensor {
 public:
  virtual ~LearntSensor() = default;
  virtual SensorPrior prior(double pixel) const = 0;
  virtual void add(const SensorEvidence& pair, double pixel) = 0;
};

/// Two cameras: pixels to be added to a disparity, and their growth with x = 1, y = 1 and x^2 + y^2 = 1.
class LearntRig : public LearntSensor {
 public:
  SensorPrior prior(double pixel) const override;
  void add(const SensorEvidence& pair, double pixel) override;

  Eigen::Vector4d mean() const;
  Eigen::Vector4d deviation() const;  ///< standard deviation of each
  /// True once one of the numbers is surely not zero, and large enough to matter.
  bool isOff() const;

 private:
  StreamConstant<4> constant_{10, 0.98};
};

/// A depth camera: 1/m to be added to an inverse depth.
class LearntOffset : public LearntSensor {
 public:
  SensorPrior prior(double pixel) const override;
  void add(const SensorEvidence& pair, double pixel) override;

  double mean() const;
  double deviation() const;
  bool isOff() const;

 private:
  StreamConstant<1> constant_{1, 0.98};
};

}  // namespace gms_ransac
