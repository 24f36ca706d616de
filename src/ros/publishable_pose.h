// The core's pose as others may take it: nothing invented, covariance finite and bounded, scale applied.
#pragma once

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

// robot_localization warns above the one and replaces a zero; anything in between is taken as it is.
constexpr double kLargestVariance = 1e3;
constexpr double kSmallestVariance = 1e-9;

/// Least standard deviations of a published pose, per axis.
struct SigmaFloor {
  double translation = 0.005;  ///< as a share of its length
  double rotation = 0.0005;    ///< radians
};

/// Leaves an unknown translation out (zero) and makes its variance large; floors the covariance, makes it finite, and
/// brings its diagonal within [kSmallestVariance, kLargestVariance].
void makePublishable(bool translation_known, const SigmaFloor& floor, RelativePose& pose);

/// Brings every entry of the diagonal into that range and makes the rest finite.
void boundCovariance(Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace gms_ransac
