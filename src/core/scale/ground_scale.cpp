#include "scale/ground_scale.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Position noise of an inlier, pixels; larger residuals scale it up.
constexpr double kPatchNoise = 0.7;
// Sine of the dip below which a ray depends mostly on the error of the pitch: 3 degrees.
constexpr double kSmallestDip = 0.05;
// Standard deviation of the angle between the translation and the ground, radians: a car's pitch and a kerb.
constexpr double kClimbSigma = 0.02;
// Points farther off than this many standard deviations lie on other things (Geman & McClure's loss levels off).
constexpr double kPlaneLossScale = 2;
constexpr int kPlaneIterations = 20;
constexpr double kEnoughOfAStep = 1e-4;
constexpr int kMostStarts = 200;
// Plane distances to try, in multiples of |t|, and their growth: two pixels where the ground is nearest.
constexpr double kNearest = 0.3, kFarthest = 60, kGrowth = 1.03;
// Least support of a plane, by points or patches and their share, and its largest uncertainty.
constexpr int kMinimumPoints = 12, kMinimumPatches = 6;
constexpr double kMinimumShare = 0.2;
constexpr double kLargestSigma = 0.15;
// Standard deviation of the height above the best plane, as a share: springs, roads that are no planes.
constexpr double kHeightSigma = 0.015;

double weightOf(double squared) {
  const double root = kPlaneLossScale * kPlaneLossScale / (kPlaneLossScale * kPlaneLossScale + squared);
  return root * root;
}

}  // namespace

void GroundScale::gather(const Triangulation& pair, const RelativePose& pose, double pixel, const GroundPrior& prior) {
  points_.clear();
  const Vector3d t = pose.R.transpose() * pose.t;  // in the current frame
  for (int i = 0; i < pair.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    const Vector3d ray(pair.x_current[k], pair.y_current[k], 1);
    // The horizon is that of the prior, or a little above it where the prior is rough.
    if (prior.down.dot(ray) < kSmallestDip * ray.norm()) continue;
    const double depth = pair.depth_current[k];
    if (depth == 0 || !std::isfinite(depth)) continue;
    const double sine = std::max(t.cross(ray).norm() / ray.norm(), 1e-3);
    points_.push_back({ray, 1 / depth, kPatchNoise * pixel / sine});
  }
}

Vector3d GroundScale::startFromPoints(const GroundPrior& prior) const {
  Vector3d best = Vector3d::Zero();
  double best_support = 0;
  const size_t stride = std::max<size_t>(1, points_.size() / kMostStarts);
  for (size_t i = 0; i < points_.size(); i += stride) {
    if (points_[i].inverse_depth <= 0) continue;
    const Vector3d m = prior.down * (points_[i].inverse_depth / prior.down.dot(points_[i].ray));
    double support = 0;
    for (const Point& point : points_) {
      const double tilt = m.norm() * std::min(prior.down_sigma, 3 * kClimbSigma) * point.ray.norm();
      const double difference = point.inverse_depth - m.dot(point.ray);
      const double variance = point.sigma * point.sigma + tilt * tilt;
      if (difference * difference < kPlaneLossScale * kPlaneLossScale * variance) support += 1;
    }
    if (support > best_support) {
      best_support = support;
      best = m;
    }
  }
  return best;
}

Vector3d GroundScale::startFromPatches(const GroundPrior& prior) const {
  Vector3d best = Vector3d::Zero();
  double best_score = 0;
  for (double distance = kNearest; distance < kFarthest; distance *= kGrowth) {
    const Vector3d m = prior.down / distance;
    const double score = patches_.score(m);
    if (score <= best_score) continue;
    best_score = score;
    best = m;
  }
  return best;
}

GroundScale::Fit GroundScale::fit(Vector3d m, const Vector3d& t, const GroundPrior& prior) const {
  Fit fit;
  for (int iteration = 0; iteration < kPlaneIterations && m.squaredNorm() > 0; ++iteration) {
    Matrix3d information = Matrix3d::Zero(), spread = Matrix3d::Zero();
    Vector3d gradient = Vector3d::Zero();
    fit.points = 0;
    for (const Point& point : points_) {
      const double residual = point.inverse_depth - m.dot(point.ray);
      const double weight = weightOf(std::pow(residual / point.sigma, 2)) / (point.sigma * point.sigma);
      information += weight * point.ray * point.ray.transpose();
      gradient += weight * residual * point.ray;
      spread += std::pow(weight * residual, 2) * point.ray * point.ray.transpose();
      fit.points += weight * point.sigma * point.sigma;
    }
    const PlaneEquations images = patches_.linearize(m);
    fit.patches = images.patches;
    information += images.H;
    gradient += images.b;
    spread += images.spread;
    // Information on the direction of m, lengths in multiples of its own.
    const double length = m.norm();
    Vector3d across[2];
    PoseModel::tangent(prior.down, across);
    const Eigen::Matrix<double, 2, 3> sideways =
        (Eigen::Matrix<double, 2, 3>() << across[0].transpose(), across[1].transpose()).finished() /
        (length * prior.down_sigma);
    const Vector3d along = t / (length * kClimbSigma);
    const Matrix3d known = sideways.transpose() * sideways + along * along.transpose();
    information += known;
    gradient -= known * m;
    spread += known;
    const Vector3d step = information.ldlt().solve(gradient);
    m += step;
    if (!m.allFinite()) break;
    fit.m = m;
    const Matrix3d inverse = information.inverse();
    fit.covariance = inverse * spread * inverse;
    if (step.norm() < kEnoughOfAStep * m.norm()) break;
  }
  if (!m.allFinite()) fit = Fit();
  return fit;
}

std::string GroundScale::doubt(const Fit& fit, const GroundPrior& prior) const {
  const bool points_agree =
      fit.points >= kMinimumPoints && fit.points >= kMinimumShare * static_cast<double>(points_.size());
  const bool patches_agree = fit.patches >= kMinimumPatches && fit.patches >= kMinimumShare * patches_.size();
  if (!(fit.m.squaredNorm() > 0) || !(points_agree || patches_agree)) {
    return "no ground is seen: of " + std::to_string(points_.size()) + " inliers and " +
           std::to_string(patches_.size()) + " patches below the horizon too few lie on one level plane";
  }
  if (fit.m.normalized().dot(prior.down) < std::cos(std::min(1.0, 3 * prior.down_sigma))) {
    return "the plane below the camera is not level as the ground should lie";
  }
  const double squared = fit.m.dot(fit.covariance * fit.m) / std::pow(fit.m.squaredNorm(), 2);
  if (!(squared < kLargestSigma * kLargestSigma)) return "the ground is seen too badly to tell a length by";
  return std::string();
}

ScaleEstimate GroundScale::measure(const Triangulation& pair, const RelativePose& pose, const Camera& camera,
                                   const GroundPrior& prior, const GroundImages& images) {
  gather(pair, pose, 1 / camera.meanFocalLength(), prior);
  const Vector3d t = pose.R.transpose() * pose.t.normalized();
  GroundPrior along = prior;
  // A camera that keeps its height moves along the ground: this resolves most of the uncertainty of the prior.
  if (prior.down_sigma > kClimbSigma && std::abs(t.dot(prior.down)) < 3 * prior.down_sigma) {
    along.down = (prior.down - t.dot(prior.down) * t).normalized();
  }
  patches_.set(images, camera, pose, along.down, kSmallestDip);
  const Vector3d start = patches_.size() >= kMinimumPatches ? startFromPatches(along) : startFromPoints(along);
  const Fit fit = this->fit(start, t, prior);
  problem_ = doubt(fit, prior);
  ScaleEstimate estimate;
  estimate.relative_sigma = 1;
  if (!problem_.empty()) return estimate;
  normal_ = fit.m.normalized();
  estimate.length = prior.camera_height * fit.m.norm();
  estimate.relative_sigma =
      std::sqrt(fit.m.dot(fit.covariance * fit.m) / std::pow(fit.m.squaredNorm(), 2) + kHeightSigma * kHeightSigma);
  estimate.features = static_cast<int>(fit.points) + fit.patches;
  return estimate;
}

}  // namespace gms_ransac
