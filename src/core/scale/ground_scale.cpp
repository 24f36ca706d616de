#include "scale/ground_scale.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

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
constexpr int kPlaneIterations = 20, kWithPatches = 8;  // a step with patches takes as long as ten without
constexpr double kEnoughOfAStep = 1e-3;                 // of the distance, whose error is fifteen times as large
constexpr int kMostStarts = 200;
// Plane distances to try, in multiples of |t|, and their growth: two pixels where the ground is nearest.
constexpr double kNearest = 0.3, kFarthest = 60, kGrowth = 1.03;
// Least support of a plane, by points or patches and their share, and its largest uncertainty.
constexpr int kMinimumPoints = 12, kMinimumPatches = 6;
constexpr double kMinimumShare = 0.2;
constexpr double kLargestSigma = 0.15;
// Standard deviation of the height above the best plane, as a share: springs, roads that are no planes.
constexpr double kHeightSigma = 0.015;

// Pixels between samples, smoothed by as much, and least between patches: they do not overlap.
constexpr int kStep = 2, kApart = 18;
// Patches at most, which bounds the time, and those of them that give scores: few at every distance, more at those
// distances that so many of the first scores favour.
constexpr int kMostPatches = 240, kFirstScored = 20, kMostScored = 80;
constexpr size_t kScoredTwice = 12;
constexpr double kSmoothing = 1.2;
// Ground farther to the side, in camera heights, may be another: gutters, kerbs, grass.
constexpr double kAside = 1.5;
constexpr float kContrast = 1.5f;
// Correlation above which a patch lies on the plane.
constexpr double kAgrees = 0.6;
constexpr int kSkip = 4;  ///< of the samples one in so many gives the score

/// Normal equations of the three numbers of a plane, in units of the noise that the patches have.
struct PlaneEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  /// Sum of the patches' gradients squared: what samples of one patch, which err together, leave of H's promise.
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  int patches = 0;  ///< that agree
};

/// Patches of the image below the horizon, compared with the other image through a plane m: points X of the current
/// camera's frame with m . X = 1, lengths in multiples of |t|.
class GroundPatches {
 public:
  /// Patches of the current image whose rays dip below the horizon of `down`.
  GroundPatches(const GroundImages& images, const Camera& camera, const RelativePose& pose, const Vector3d& down)
      : camera_(camera), R_(pose.R), t_(pose.t.normalized()) {
    if (images.reference.empty() || images.current.empty()) return;
    const CameraIntrinsics& k = camera.pinhole();
    const Vector3d sideways = down.cross(R_.transpose() * t_).normalized();
    constexpr int kMargin = kStep * (kSide / 2) + 1;
    const cv::Size size = images.current.size();
    const int apart = std::max(kApart, static_cast<int>(std::sqrt(0.5 * size.width * size.height / kMostPatches)));
    std::vector<cv::Point> centres;  // lower ones first
    for (int y = size.height - 1 - kMargin; y >= kMargin; y -= apart) {
      for (int x = kMargin; x + kMargin < size.width; x += apart) {
        const Vector3d ray((x - k.cx) / k.fx, (y - k.cy) / k.fy, 1);
        if (down.dot(ray) < kSmallestDip * ray.norm() || std::abs(sideways.dot(ray)) > kAside * down.dot(ray)) continue;
        centres.emplace_back(x, y);
      }
    }
    if (centres.empty()) return;
    const int top = centres.back().y - kMargin;
    const cv::Mat current = smoothBelow(images.current, top);
    // The other image may show the same ground nearer to the horizon.
    top_ = std::max(0, top - static_cast<int>(2 * kSmallestDip * k.fy));
    reference_ = smoothBelow(images.reference, top_);
    Patch patch;
    for (const cv::Point& centre : centres) {
      if (cut(current, centre, top, patch)) patches_.push_back(patch);
    }
  }

  int size() const { return static_cast<int>(patches_.size()); }

  /// Sum over some of the patches, by every few of their samples, of how well they correlate beyond chance.
  double score(const Vector3d& m, int most) const {
    double sum = 0;
    const size_t stride = 1 + patches_.size() / static_cast<size_t>(most);
    for (size_t k = 0; k < patches_.size(); k += stride) {
      const Patch& patch = patches_[k];
      Eigen::Array<double, (kSamples + kSkip - 1) / kSkip, 2> values;  // of the other image and its own
      bool inside = true;
      for (int i = 0; i < kSamples && inside; i += kSkip) {
        float value = 0;
        inside = look(m, patch.rays.col(i).cast<double>(), value, nullptr);
        values.row(i / kSkip) << value, patch.values[i];
      }
      if (!inside) continue;
      values.rowwise() -= values.colwise().mean().eval();
      const auto squares = values.square().colwise().sum().eval();
      const double correlation = values.rowwise().prod().sum() / std::sqrt(std::max(squares.prod(), 1e-12));
      sum += std::max(0.0, correlation - 0.5 * kAgrees);
    }
    return sum;
  }

  PlaneEquations linearize(const Vector3d& m) const {
    PlaneEquations equations;
    double squares = 0, samples = 0;
    Eigen::Matrix<double, kSamples, 3> J;
    Eigen::Matrix<double, kSamples, 1> values;
    for (const Patch& patch : patches_) {
      bool inside = true;
      for (int i = 0; i < kSamples && inside; ++i) {
        float value = 0;
        Eigen::RowVector3d derivative = Eigen::RowVector3d::Zero();
        inside = look(m, patch.rays.col(i).cast<double>(), value, &derivative);
        values[i] = value;
        J.row(i) = derivative;
      }
      if (!inside) continue;
      values.array() -= values.mean();
      J.rowwise() -= J.colwise().mean().eval();
      const double norm = values.norm();
      if (!(norm > 1e-6)) continue;
      values /= norm;
      J /= norm;
      const double correlation = values.dot(patch.values.cast<double>());
      if (correlation < kAgrees) continue;
      const double weight = (correlation - kAgrees) / (1 - kAgrees);
      const Eigen::Matrix<double, kSamples, 1> residual = patch.values.cast<double>() - values;
      const Vector3d gradient = weight * J.transpose() * residual;
      equations.H += weight * J.transpose() * J;
      equations.b += gradient;
      equations.spread += gradient * gradient.transpose();
      squares += weight * residual.squaredNorm();
      samples += weight * kSamples;
      ++equations.patches;
    }
    if (equations.patches == 0) return equations;
    const double variance = std::max(squares / std::max(1.0, samples), 1e-9);
    equations.H /= variance;
    equations.b /= variance;
    equations.spread /= variance * variance;
    return equations;
  }

 private:
  static constexpr int kSide = 9, kSamples = kSide * kSide;
  struct Patch {
    Eigen::Matrix<float, 3, kSamples> rays;    ///< (x, y, 1)
    Eigen::Matrix<float, kSamples, 1> values;  ///< grey levels, mean 0 and norm 1
  };

  static cv::Mat smoothBelow(const cv::Mat& image, int top) {
    cv::Mat smooth;
    image.rowRange(top, image.rows).convertTo(smooth, CV_32F);
    cv::GaussianBlur(smooth, smooth, cv::Size(), kSmoothing);
    return smooth;
  }

  /// `top`: row of the received image that is the first one of `image`.
  bool cut(const cv::Mat& image, const cv::Point& centre, int top, Patch& patch) const {
    for (int i = 0; i < kSamples; ++i) {
      const int u = centre.x + kStep * (i % kSide - kSide / 2), v = centre.y + kStep * (i / kSide - kSide / 2);
      const Eigen::Vector2d ray = rayOf(camera_, {static_cast<float>(u), static_cast<float>(v)});
      if (!ray.allFinite()) return false;
      patch.rays.col(i) = ray.homogeneous().cast<float>();
      patch.values[i] = image.at<float>(v - top, u);
    }
    patch.values.array() -= patch.values.mean();
    const float norm = patch.values.norm();
    patch.values /= std::max(norm, 1e-6f);
    return norm > kContrast * std::sqrt(static_cast<float>(kSamples));
  }

  /// Grey level and its gradient by the normalised image plane, where the reference shows a point of the plane; false
  /// outside.
  bool look(const Vector3d& m, const Vector3d& ray, float& value, Eigen::RowVector3d* derivative) const {
    // X = ray / (m . ray), seen from the reference as R X + t, or as anything along it.
    const Vector3d seen = R_ * ray + m.dot(ray) * t_;
    if (!(seen.z() > 1e-3)) return false;
    const CameraIntrinsics& k = camera_.pinhole();
    const Eigen::Vector2d at = seen.head<2>() / seen.z();
    cv::Point2f pixel(static_cast<float>(k.fx * at.x() + k.cx), static_cast<float>(k.fy * at.y() + k.cy));
    if (camera_.distorts()) pixel = camera_.distort(pixel);
    pixel.y -= static_cast<float>(top_);
    // Asked of the numbers as they are: NaN, where the lens has no inverse, and what is far away are no index.
    const bool inside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < static_cast<float>(reference_.cols - 1) &&
                        pixel.y < static_cast<float>(reference_.rows - 1);
    if (!inside) return false;
    const int u = static_cast<int>(pixel.x), v = static_cast<int>(pixel.y);
    const float a = pixel.x - static_cast<float>(u), b = pixel.y - static_cast<float>(v);
    const float* top = reference_.ptr<float>(v) + u;
    const float* bottom = reference_.ptr<float>(v + 1) + u;
    value = (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * bottom[0] + a * bottom[1]);
    if (derivative == nullptr) return true;
    const double by_u = (1 - b) * (top[1] - top[0]) + b * (bottom[1] - bottom[0]);
    const double by_v = (1 - a) * (bottom[0] - top[0]) + a * (bottom[1] - top[1]);
    const double by_inverse =
        (k.fx * by_u * (t_.x() - at.x() * t_.z()) + k.fy * by_v * (t_.y() - at.y() * t_.z())) / seen.z();
    *derivative = by_inverse * ray.transpose();
    return true;
  }

  const Camera& camera_;
  Matrix3d R_;
  Vector3d t_;
  cv::Mat reference_;  ///< smoothed, from the row `top_` on
  int top_ = 0;
  std::vector<Patch> patches_;
};

struct Point {
  Vector3d ray;  ///< (x, y, 1) in the current image
  double inverse_depth, sigma;
};

struct Fit {
  Vector3d m = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();
  double points = 0;  ///< sum of their weights
  int patches = 0;
};

double weightOf(double squared) {
  const double root = kPlaneLossScale * kPlaneLossScale / (kPlaneLossScale * kPlaneLossScale + squared);
  return root * root;
}

std::vector<Point> gather(const Triangulation& pair, const RelativePose& pose, double pixel, const GroundPrior& prior) {
  std::vector<Point> points;
  const Vector3d t = pose.R.transpose() * pose.t;  // in the current frame
  for (int i = 0; i < pair.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    const Vector3d ray(pair.x_current[k], pair.y_current[k], 1);
    // The horizon is that of the prior, or a little above it where the prior is rough.
    if (prior.down.dot(ray) < kSmallestDip * ray.norm()) continue;
    const double depth = pair.depth_current[k];
    if (depth == 0 || !std::isfinite(depth)) continue;
    const double sine = std::max(t.cross(ray).norm() / ray.norm(), 1e-3);
    points.push_back({ray, 1 / depth, kPatchNoise * pixel / sine});
  }
  return points;
}

/// The plane of one point and the prior's normal with the most support; zero: none.
Vector3d startFromPoints(const std::vector<Point>& points, const GroundPrior& prior) {
  Vector3d best = Vector3d::Zero();
  double best_support = 0;
  const size_t stride = std::max<size_t>(1, points.size() / kMostStarts);
  for (size_t i = 0; i < points.size(); i += stride) {
    if (points[i].inverse_depth <= 0) continue;
    const Vector3d m = prior.down * (points[i].inverse_depth / prior.down.dot(points[i].ray));
    double support = 0;
    for (const Point& point : points) {
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

/// The plane with the prior's normal through which the images agree best; zero: none.
Vector3d startFromPatches(const GroundPatches& patches, const GroundPrior& prior) {
  std::vector<std::pair<double, double>> scores;  // and distances
  for (double distance = kNearest; distance < kFarthest; distance *= kGrowth) {
    scores.emplace_back(patches.score(prior.down / distance, kFirstScored), distance);
  }
  std::partial_sort(scores.begin(), scores.begin() + kScoredTwice, scores.end(), std::greater<>());
  Vector3d best = Vector3d::Zero();
  double best_score = 0;
  for (size_t i = 0; i < kScoredTwice; ++i) {
    const Vector3d m = prior.down / scores[i].second;
    const double score = patches.score(m, kMostScored);
    if (score <= best_score) continue;
    best_score = score;
    best = m;
  }
  return best;
}

Fit fitPlane(Vector3d m, const Vector3d& t, const std::vector<Point>& points, const GroundPatches& patches,
             const GroundPrior& prior) {
  Fit fit;
  const int iterations = patches.size() > 0 ? kWithPatches : kPlaneIterations;
  for (int iteration = 0; iteration < iterations && m.squaredNorm() > 0; ++iteration) {
    Matrix3d information = Matrix3d::Zero(), spread = Matrix3d::Zero();
    Vector3d gradient = Vector3d::Zero();
    fit.points = 0;
    for (const Point& point : points) {
      const double residual = point.inverse_depth - m.dot(point.ray);
      const double weight = weightOf(std::pow(residual / point.sigma, 2)) / (point.sigma * point.sigma);
      information += weight * point.ray * point.ray.transpose();
      gradient += weight * residual * point.ray;
      spread += std::pow(weight * residual, 2) * point.ray * point.ray.transpose();
      fit.points += weight * point.sigma * point.sigma;
    }
    const PlaneEquations images = patches.linearize(m);
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

/// Why the fit is no ground; empty if it is.
std::string doubtOf(const Fit& fit, size_t points, int patches, const GroundPrior& prior) {
  const bool points_agree = fit.points >= kMinimumPoints && fit.points >= kMinimumShare * static_cast<double>(points);
  const bool patches_agree = fit.patches >= kMinimumPatches && fit.patches >= kMinimumShare * patches;
  if (!(fit.m.squaredNorm() > 0) || !(points_agree || patches_agree)) {
    return "no ground is seen: of " + std::to_string(points) + " inliers and " + std::to_string(patches) +
           " patches below the horizon too few lie on one level plane";
  }
  if (fit.m.normalized().dot(prior.down) < std::cos(std::min(1.0, 3 * prior.down_sigma))) {
    return "the plane below the camera is not level as the ground should lie";
  }
  const double squared = fit.m.dot(fit.covariance * fit.m) / std::pow(fit.m.squaredNorm(), 2);
  if (!(squared < kLargestSigma * kLargestSigma)) return "the ground is seen too badly to tell a length by";
  return std::string();
}

}  // namespace

Ground measureGround(const Triangulation& pair, const RelativePose& pose, const Camera& camera,
                     const GroundPrior& prior, const GroundImages& images) {
  const std::vector<Point> points = gather(pair, pose, 1 / camera.meanFocalLength(), prior);
  const Vector3d t = pose.R.transpose() * pose.t.normalized();
  GroundPrior along = prior;
  // A camera that keeps its height moves along the ground: this resolves most of the uncertainty of the prior.
  if (prior.down_sigma > kClimbSigma && std::abs(t.dot(prior.down)) < 3 * prior.down_sigma) {
    along.down = (prior.down - t.dot(prior.down) * t).normalized();
  }
  const GroundPatches patches(images, camera, pose, along.down);
  const Vector3d start =
      patches.size() >= kMinimumPatches ? startFromPatches(patches, along) : startFromPoints(points, along);
  const Fit fit = fitPlane(start, t, points, patches, prior);
  Ground ground;
  ground.scale.relative_sigma = 1;
  ground.problem = doubtOf(fit, points.size(), patches.size(), prior);
  if (!ground.problem.empty()) return ground;
  ground.normal = fit.m.normalized();
  ground.scale.length = prior.camera_height * fit.m.norm();
  ground.scale.relative_sigma =
      std::sqrt(fit.m.dot(fit.covariance * fit.m) / std::pow(fit.m.squaredNorm(), 2) + kHeightSigma * kHeightSigma);
  ground.scale.features = static_cast<int>(fit.points) + fit.patches;
  return ground;
}

}  // namespace gms_ransac
