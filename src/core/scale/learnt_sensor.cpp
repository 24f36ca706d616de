#include "scale/learnt_sensor.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using One = Eigen::Matrix<double, 1, 1>;

// Prior standard deviations, pixels. KITTI's rectified images have an offset of 0.1 (04, 06) and 1.0 (01), and 1.5 to
// 2.3 over x^2: ignored, they make the translation 0.8, 0.5 and 8 % too long. Growth with y is what the rows of both
// images leave of it (RowOffsets::disparityError): a road alone does not tell it from the length.
const double kSigma[4] = {1, 0.3, 0.1, 1};
constexpr double kSurely = 4, kMatters = 0.3;  ///< standard deviations, and pixels

// The same of a depth camera, 1/m: a fifth of a pixel of a Kinect's disparity.
constexpr double kOffsetSigma = 0.005, kOffsetMatters = 0.003;
// Prior standard deviation of the row rotation, radians: half a degree to one degree on a hand-held Kinect.
constexpr double kRowRotationSigma = 3.14159265358979323846 / 180;

Matrix4d calibrated() { return Vector4d(kSigma).cwiseAbs2().cwiseInverse().asDiagonal(); }
One calibratedOffset() { return One(1 / (kOffsetSigma * kOffsetSigma)); }
Matrix3d rowRotation() { return Matrix3d::Identity() / (kRowRotationSigma * kRowRotationSigma); }

}  // namespace

SensorPrior LearntRig::prior(double pixel) const {
  return {pixel * mean(), constant_.information(calibrated()) / (pixel * pixel), 0};
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

SensorPrior LearntOffset::prior(double) const {
  SensorPrior prior = {Vector4d(0, 0, 0, mean()), Matrix4d::Zero(), 3};
  prior.information.topLeftCorner<3, 3>() = rowRotation();
  prior.information.bottomRightCorner<1, 1>() = constant_.information(calibratedOffset());
  return prior;
}

void LearntOffset::add(const SensorEvidence& pair, double) {
  // The row rotation is of the pair alone: it is eliminated.
  const Vector3d coupling = pair.information.topRightCorner<3, 1>();
  const Matrix3d rotation = pair.information.topLeftCorner<3, 3>() + rowRotation();
  const Vector3d follow = rotation.ldlt().solve(coupling);
  constant_.add(One(pair.score[3] - follow.dot(pair.score.head<3>())),
                One(pair.information(3, 3) - follow.dot(coupling)));
}

double LearntOffset::mean() const { return constant_.mean(calibratedOffset())[0]; }

double LearntOffset::deviation() const { return 1 / std::sqrt(constant_.information(calibratedOffset())(0, 0)); }

bool LearntOffset::isOff() const {
  return std::abs(mean()) > kOffsetMatters && std::abs(mean()) > kSurely * deviation();
}

}  // namespace gms_ransac
