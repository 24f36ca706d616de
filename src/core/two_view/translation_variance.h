// Covariance of a pose whose translation is unknown, or known to a given variance alone.
#pragma once

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// Published for an unknown translation (Correspondences.msg).
constexpr double kUnknownTranslationVariance = 1e3;
/// Variance of each coordinate of a unit vector of any direction.
constexpr double kAnyDirection = 1. / 3;

/// The translation, which comes first, gets this variance in each axis and no correlation; the rotation keeps its own.
inline void setTranslationVariance(double variance, Covariance6d& covariance) {
  covariance.topRows<3>().setZero();
  covariance.leftCols<3>().setZero();
  covariance.diagonal().head<3>().setConstant(variance);
}

}  // namespace gms_ransac
