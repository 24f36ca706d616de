#include "camera/distortion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace gms_ransac {

namespace {

// Ideal radius beyond which nothing is undistorted: 0.6 degrees short of a right angle to the axis, where a pinhole
// camera sees nothing.
constexpr double kWidestRadius = 100;
// Steps of the search for the end of growth, even in the angle to the axis.
constexpr int kAngleSteps = 2000;
// Largest residual of the inverse, normalised: less than 1e-7 px at any focal length.
constexpr double kResidual = 1e-11;
constexpr int kNewtonSteps = 40;

double polynomial(const double* c, int degree, double x) {
  double value = c[degree];
  for (int i = degree - 1; i >= 0; --i) value = value * x + c[i];
  return value;
}

double derivativeOf(const double* c, int degree, double x) {
  double value = degree * c[degree];
  for (int i = degree - 1; i >= 1; --i) value = value * x + i * c[i];
  return value;
}

/// Projection onto a sensor rotated about x, then about y.
Eigen::Matrix3d sensorTilt(double about_x, double about_y) {
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(-about_y, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(-about_x, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  Eigen::Matrix3d projection;
  projection << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;
  return projection * R;
}

}  // namespace

std::string commonModelName(const std::string& model) {
  if (model == "fisheye") return "equidistant";
  if (model == "radtan") return "plumb_bob";
  if (model == "mei" || model == "omni" || model == "omni-radtan") return "omnidirectional";
  if (model == "ds") return "double_sphere";
  return model == "none" ? "" : model;
}

bool hasSpheres(const std::string& model) { return model == "omnidirectional" || model == "double_sphere"; }

double magnificationOf(const CameraIntrinsics& intrinsics) {
  return hasSpheres(intrinsics.distortion_model) ? 1 + intrinsics.distortion[0] : 1;
}

Distortion::Distortion(const CameraIntrinsics& intrinsics) : fisheye_(intrinsics.distortion_model == "equidistant") {
  // In the order of sensor_msgs/CameraInfo: k1 k2 p1 p2 k3, k4 k5 k6, s1 s2 s3 s4, tau_x tau_y; those of a sphere
  // first.
  std::vector<double> d = intrinsics.distortion;
  if (hasSpheres(intrinsics.distortion_model)) {
    const bool two = intrinsics.distortion_model == "double_sphere";  // and no lens behind them
    xi_ = d[0];
    alpha_ = two ? d[1] : 0;
    d.erase(d.begin(), two ? d.end() : d.begin() + 1);
  }
  const auto at = [&d](size_t i) { return i < d.size() ? d[i] : 0; };
  if (fisheye_) {
    for (size_t i = 0; i < 4; ++i) numerator_[i + 1] = at(i);
  } else {
    numerator_[1] = at(0);
    numerator_[2] = at(1);
    p1_ = at(2);
    p2_ = at(3);
    numerator_[3] = at(4);
    for (size_t i = 0; i < 3; ++i) denominator_[i + 1] = at(5 + i);
    for (size_t i = 0; i < 2; ++i) {
      prism_x_[i] = at(8 + i);
      prism_y_[i] = at(10 + i);
    }
    tilt_ = sensorTilt(at(12), at(13));
    untilt_ = tilt_.inverse();
  }
  largest_radius_ = radiusOfGrowth();
  reach_ = farthestOnRim();
}

Distortion::Radial Distortion::radial(double squared_radius) const {
  const double r = std::sqrt(squared_radius);
  if (fisheye_) {
    if (r < 1e-8) return {1, 1};
    const double angle = std::atan(r), squared = angle * angle;
    const double share = polynomial(numerator_, 4, squared);
    return {angle * share / r, (share + 2 * squared * derivativeOf(numerator_, 4, squared)) / (1 + squared_radius)};
  }
  const double above = polynomial(numerator_, 3, squared_radius), below = polynomial(denominator_, 3, squared_radius);
  const double factor = above / below;
  const double change =
      (derivativeOf(numerator_, 3, squared_radius) - factor * derivativeOf(denominator_, 3, squared_radius)) / below;
  return {factor, factor + 2 * squared_radius * change};
}

Distortion::Radial Distortion::sphere(double squared_radius) const {
  // A ray (r, 1) is r / (alpha d + (1 - alpha) w), w = 1 + xi rho, d = |(r, w)|, rho = |(r, 1)|; alpha is 0 for one
  // sphere. `below` and its derivative by r, times r:
  const double rho = std::sqrt(1 + squared_radius), w = 1 + xi_ * rho, d = std::sqrt(squared_radius + w * w);
  const double w_slope = xi_ * squared_radius / rho, d_slope = (squared_radius + w * w_slope) / d;
  const double below = alpha_ * d + (1 - alpha_) * w, slope = alpha_ * d_slope + (1 - alpha_) * w_slope;
  return {1 / below, (1 - slope / below) / below};
}

Eigen::Matrix2d Distortion::byPoint(const Radial& at, const Eigen::Vector2d& point) {
  Eigen::Matrix2d derivative = at.factor * Eigen::Matrix2d::Identity();
  const double squared = point.squaredNorm();
  if (squared > 0) derivative += (at.slope - at.factor) / squared * point * point.transpose();
  return derivative;
}

double Distortion::radiusOfGrowth() const {
  const double widest = std::atan(kWidestRadius);
  double last = 0;
  for (int i = 1; i <= kAngleSteps; ++i) {
    const double r = std::tan(widest * i / kAngleSteps);
    const Radial before = sphere(r * r), lens = radial(r * r * before.factor * before.factor);
    const Radial at = {before.factor * lens.factor, before.slope * lens.slope};
    if (!(before.slope > 0) || !(at.slope > 0) || !(at.factor > 0) || !std::isfinite(at.slope)) break;
    last = r;
  }
  return last;
}

double Distortion::farthestOnRim() const {
  constexpr int kDirections = 64;
  constexpr double kBetweenDirections = 1.01;
  double farthest = 0;
  Eigen::Matrix2d unused;
  for (int i = 0; i < kDirections; ++i) {
    const Eigen::Rotation2Dd rotation(2 * M_PI * i / kDirections);
    farthest = std::max(farthest, distortOnLens(rotation * Eigen::Vector2d(largest_radius_, 0), unused).norm());
  }
  return kBetweenDirections * farthest;
}

Eigen::Vector2d Distortion::distortOnLens(const Eigen::Vector2d& ideal, Eigen::Matrix2d& derivative) const {
  const Radial at = sphere(ideal.squaredNorm());
  const Eigen::Vector2d plane = distortOnPlane(at.factor * ideal, derivative);
  derivative = (1 + xi_) * derivative * byPoint(at, ideal);
  return (1 + xi_) * plane;
}

Eigen::Vector2d Distortion::distortOnPlane(const Eigen::Vector2d& ideal, Eigen::Matrix2d& derivative) const {
  const double x = ideal.x(), y = ideal.y(), squared = ideal.squaredNorm();
  const Radial at = radial(squared);
  derivative = byPoint(at, ideal);
  Eigen::Matrix2d sideways;
  sideways << 2 * p1_ * y + 6 * p2_ * x, 2 * p1_ * x + 2 * p2_ * y, 2 * p1_ * x + 2 * p2_ * y,
      6 * p1_ * y + 2 * p2_ * x;
  const Eigen::Vector2d prism_slope(2 * (prism_x_[0] + 2 * prism_x_[1] * squared),
                                    2 * (prism_y_[0] + 2 * prism_y_[1] * squared));
  derivative += sideways + prism_slope * ideal.transpose();
  return at.factor * ideal +
         Eigen::Vector2d(
             2 * p1_ * x * y + p2_ * (squared + 2 * x * x) + (prism_x_[0] + prism_x_[1] * squared) * squared,
             p1_ * (squared + 2 * y * y) + 2 * p2_ * x * y + (prism_y_[0] + prism_y_[1] * squared) * squared);
}

Eigen::Vector2d Distortion::distort(const Eigen::Vector2d& ideal) const {
  Eigen::Matrix2d unused;
  return (tilt_ * distortOnLens(ideal, unused).homogeneous()).hnormalized();
}

bool Distortion::undistort(const Eigen::Vector2d& distorted, Eigen::Vector2d& ideal) const {
  const Eigen::Vector2d target = (untilt_ * distorted.homogeneous()).hnormalized();
  if (!(target.norm() < reach_)) return false;  // nor if it is not finite
  ideal = target;
  // Newton's method comes from the inside where r_d bends down and from the outside where it bends up, either way
  // without passing the answer; steps are halved for what lies between.
  constexpr double kInside = 0.95;
  const double radius = ideal.norm();
  if (radius > kInside * largest_radius_) ideal *= kInside * largest_radius_ / radius;
  Eigen::Matrix2d derivative;
  Eigen::Vector2d residual = distortOnLens(ideal, derivative) - target;
  for (int i = 0; i < kNewtonSteps && residual.norm() > kResidual; ++i) {
    if (!stepCloser(derivative.inverse() * residual, target, ideal, derivative, residual)) return false;
  }
  return residual.norm() <= kResidual && derivative.determinant() > 0;
}

bool Distortion::stepCloser(Eigen::Vector2d step, const Eigen::Vector2d& target, Eigen::Vector2d& ideal,
                            Eigen::Matrix2d& derivative, Eigen::Vector2d& residual) const {
  constexpr int kHalvings = 20;
  for (int i = 0; i < kHalvings; ++i, step *= 0.5) {
    const Eigen::Vector2d next = ideal - step;
    if (!(next.norm() < largest_radius_)) continue;
    Eigen::Matrix2d next_derivative;
    const Eigen::Vector2d next_residual = distortOnLens(next, next_derivative) - target;
    if (!(next_residual.norm() < residual.norm())) continue;
    ideal = next;
    derivative = next_derivative;
    residual = next_residual;
    return true;
  }
  return false;
}

}  // namespace gms_ransac
