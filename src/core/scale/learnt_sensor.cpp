#include "scale/learnt_sensor.h"

#include <Eigen/LU>

namespace gms_ransac {

namespace {

using Eigen::Matrix4d;
using Eigen::Vector4d;

// Prior standard deviations, pixels. KITTI's rectified images have an offset of 0.1 (04, 06) and 1.0 (01), and 1.5 to
// 2.3 over x^2: ignored, they make the translation 0.8, 0.5 and 8 % too long. Growth with y is what the rows of both
// images leave of it (RowOffsets::disparityError): a road alone does not tell it from the length.
const double kSigma[4] = {1, 0.3, 0.1, 1};
constexpr double kSurely = 4, kMatters = 0.3;  ///< standard deviations, and pixels

Matrix4d calibrated() { return Vector4d(kSigma).cwiseAbs2().cwiseInverse().asDiagonal(); }

}  // namespace

SensorPrior LearntRig::prior(double pixel) const {
  return {pixel * mean(), constant_.information(calibrated()) / (pixel * pixel)};
}

void LearntRig::add(const SensorEvidence& pair, double pixel) {
  constant_.add(pixel * pair.score, pixel * pixel * pair.information);
}

Vector4d LearntRig::mean() const { return constant_.mean(calibrated()); }

Vector4d LearntRig::deviation() const {
  return Matrix4d(constant_.information(calibrated())).inverse().diagonal().cwiseSqrt();
}

bool LearntRig::isOff() const {
  const Eigen::Array4d size = mean().cwiseAbs();
  return (size > kMatters && size > kSurely * deviation().array()).any();
}

}  // namespace gms_ransac
