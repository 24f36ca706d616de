// The core's pose as others may take it: nothing invented, covariance finite and bounded, scale applied.
#pragma once

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

// robot_localization warns above the one and replaces a zero; anything in between is taken as it is.
constexpr double kLargestVariance = 1e3;
constexpr double kSmallestVariance = 1e-9;

/// Least standard deviations of a published pose, per axis.
struct SigmaFloor {
  double translation = 0.005;  ///< in units of the translation
  double rotation = 0.0005;    ///< radians
};

/// An unobservable direction of translation is left out (zero) and its variance large; the covariance is floored,
/// finite, and its diagonal within [kSmallestVariance, kLargestVariance].
RelativePose publishablePose(const RobustResult& robust, const SigmaFloor& floor);

/// Brings every entry of the diagonal into that range and makes the rest finite.
void boundCovariance(Eigen::Matrix<double, 6, 6>& covariance);

/// Gives the unit translation of `pose` its length; `length_sigma` (same unit) becomes the uncertainty along it.
void applyScale(double length, double length_sigma, RelativePose& pose);

}  // namespace gms_ransac
