// The core's pose as others may take it: nothing invented, covariance finite and bounded, scale applied.
#pragma once

#include <string>

#include "gms_ransac/robust_result.h"
#include "two_view/translation_variance.h"

namespace gms_ransac {

// robot_localization warns above the one and replaces a zero; anything in between is taken as it is.
constexpr double kLargestVariance = kUnknownTranslationVariance;
constexpr double kSmallestVariance = 1e-9;

/// Least standard deviations of a published pose, per axis.
struct SigmaFloor {
  double translation = 0.005;  ///< as a share of its length
  double rotation = 0.0005;    ///< radians
};

/// Sets an unknown translation to zero with a large variance, adds the floors and bounds the diagonal to
/// [kSmallestVariance, kLargestVariance]. An invalid covariance (not finite, negative, not symmetric) stays as it is,
/// for poseDefect to find.
void makePublishable(bool translation_known, const SigmaFloor& floor, RelativePose& pose);

/// The last check of a pose before it is published: why it must not be, or empty. Fit is one that is finite, with a
/// rotation matrix up to rounding and a covariance that is symmetric and positive definite.
std::string poseDefect(const RelativePose& pose);

/// Brings every entry of the diagonal into that range, makes the rest finite and the whole symmetric.
void boundCovariance(Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace gms_ransac
