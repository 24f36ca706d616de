#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "scale/translation_scale.h"

namespace gms_ransac {

namespace {

constexpr int kMinimumSupport = 8;
// Position noise of an inlier, pixels; only the ratio of the variances it leads to matters.
constexpr double kPixelNoise = 1.0;
// Residuals beyond this many standard deviations count as outliers (Cauchy's loss levels off).
constexpr double kLossScale = 2.0;
// The search: a factor of kSearchRange either way of the start, in log steps, then golden section.
constexpr double kSearchRange = 1.6;
constexpr int kSearchSteps = 24;
// After a loss the start may be wrong by several times.
constexpr double kWideRange = 16;
constexpr int kWideSteps = 142;  // of the same width
constexpr int kGoldenSteps = 24;
// A carried inverse depth counts at most as this many fresh measurements: what links pairs is correlated and drifts.
constexpr double kMemory = 4;
// Fresh and carried inverse depth that differ by more standard deviations than this belong to different things.
constexpr double kGate = 3;
// Relative standard deviation of a length that is only the previous one's.
constexpr double kUnmeasured = 1;

/// Sine of the angle between the translation and a ray: how much of the baseline moves that point in the image.
double sineToBaseline(const Eigen::Vector3d& t, const Eigen::Vector3d& ray) {
  return t.normalized().cross(ray).norm() / ray.norm();
}

/// `centre` must be positive.
double minimiseInLog(double centre, double range, int steps, const std::function<double(double)>& cost) {
  double best = centre, best_cost = cost(centre);
  const double step = std::log(range) / steps;
  for (int k = -steps; k <= steps; ++k) {
    const double s = centre * std::exp(k * step), c = cost(s);
    if (c < best_cost) {
      best_cost = c;
      best = s;
    }
  }
  constexpr double kGolden = 0.6180339887498949;
  double low = std::log(best) - step, high = std::log(best) + step;
  for (int k = 0; k < kGoldenSteps; ++k) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    const bool lower = cost(std::exp(a)) < cost(std::exp(b));
    (lower ? high : low) = lower ? b : a;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

ScaleEstimate ScalePropagator::measure(const Triangulation& pair, const MatchResult& result, double pixel,
                                       bool after_loss) {
  ratios_.clear();
  const Eigen::Vector3d& t = result.robust.judgement.pose.t;
  for (int i = 0; i < pair.size(); ++i) {
    const auto keypoint = static_cast<size_t>(result.matches[pair.row[i]].reference);
    if (keypoint >= reference_.size() || reference_[keypoint].variance == 0) continue;
    // A negative depth is noise about infinity; leaving it out would favour the near.
    if (pair.depth_reference[i] == 0 || !std::isfinite(pair.depth_reference[i])) continue;
    const double sine = sineToBaseline(t, {pair.x_reference[i], pair.y_reference[i], 1});
    const double sigma = kPixelNoise * pixel / std::max(sine, 1e-3);
    ratios_.push_back(
        {1 / pair.depth_reference[i], sigma * sigma, reference_[keypoint].value, reference_[keypoint].variance});
  }
  ScaleEstimate estimate;
  estimate.length = length_;
  if (!std::exchange(has_unit_, true)) return estimate;
  estimate.relative_sigma = kUnmeasured;
  if (static_cast<int>(ratios_.size()) < kMinimumSupport) return estimate;

  // length = unit / known. Both carry noise; single ratios would be biased.
  const auto cost = [this](double length) {
    double sum = 0;
    for (const Ratio& r : ratios_) {
      const double residual = r.unit - length * r.known;
      const double variance = r.unit_variance + length * length * r.known_variance;
      sum += std::log1p(residual * residual / (kLossScale * kLossScale * variance));
    }
    return sum;
  };
  const double start = startingLength();
  if (!(start > 0) || !std::isfinite(start)) return estimate;
  estimate.length = after_loss ? minimiseInLog(start, kWideRange, kWideSteps, cost)
                               : minimiseInLog(start, kSearchRange, kSearchSteps, cost);
  double information = 0;
  for (const Ratio& r : ratios_) {
    const double variance = r.unit_variance + estimate.length * estimate.length * r.known_variance;
    information += r.known * r.known / variance;
  }
  estimate.relative_sigma = 1 / (estimate.length * std::sqrt(information));
  estimate.features = static_cast<int>(ratios_.size());
  return estimate;
}

double ScalePropagator::startingLength() const {
  std::vector<std::pair<double, double>> by_accuracy;
  for (const Ratio& r : ratios_) {
    by_accuracy.emplace_back(r.unit_variance / (r.unit * r.unit) + r.known_variance / (r.known * r.known),
                             r.unit / r.known);
  }
  const size_t best = std::max<size_t>(kMinimumSupport, by_accuracy.size() / 2);
  std::nth_element(by_accuracy.begin(), by_accuracy.begin() + (best - 1), by_accuracy.end());
  by_accuracy.resize(best);
  const auto middle = by_accuracy.begin() + best / 2;
  std::nth_element(by_accuracy.begin(), middle, by_accuracy.end(),
                   [](const auto& a, const auto& b) { return a.second < b.second; });
  return middle->second;
}

void ScalePropagator::carryOn(const Triangulation& pair, const MatchResult& result, double pixel, double length) {
  current_.assign(static_cast<size_t>(result.keypoints_current), InverseDepth());
  const RelativePose& pose = result.robust.judgement.pose;
  for (int i = 0; i < pair.size(); ++i) {
    if (pair.depth_current[i] <= 0 || !std::isfinite(pair.depth_current[i])) continue;
    const Match& match = result.matches[pair.row[i]];
    const double sine = sineToBaseline(pose.t, pose.R * Eigen::Vector3d(pair.x_current[i], pair.y_current[i], 1));
    const double sigma = kPixelNoise * pixel / (std::max(sine, 1e-3) * length);
    const double fresh_variance = sigma * sigma;
    InverseDepth depth = {1 / (length * pair.depth_current[i]), fresh_variance};
    const auto keypoint = static_cast<size_t>(match.reference);
    if (keypoint < reference_.size() && reference_[keypoint].variance > 0 && reference_[keypoint].value > 0) {
      const InverseDepth& old = reference_[keypoint];
      const Eigen::Vector3d ray(pair.x_reference[i], pair.y_reference[i], 1);
      const double z = (pose.R.transpose() * (ray / old.value - length * pose.t)).z();
      if (z > 0) {
        const double stretch = std::pow(1 / (old.value * z), 2);  // d(inverse depth there) / d(inverse depth here)
        const double prior = 1 / z;
        const double prior_variance = std::max(old.variance * stretch * stretch, fresh_variance / kMemory);
        const double difference = prior - depth.value, variance = prior_variance + fresh_variance;
        if (difference * difference < kGate * kGate * variance) {
          depth.value += difference * fresh_variance / variance;
          depth.variance = prior_variance * fresh_variance / variance;
        }
      }
    }
    // Nothing that is not finite enters the memory: it would spread from pair to pair.
    if (depth.value > 0 && std::isfinite(depth.value) && std::isnormal(depth.variance)) {
      current_[static_cast<size_t>(match.current)] = depth;
    }
  }
}

ScaleEstimate ScalePropagator::update(const Triangulation& pair, const MatchResult& result, const Camera& camera,
                                      bool after_loss) {
  const double pixel = camera.calibrated() ? 1 / camera.meanFocalLength() : 1;
  const ScaleEstimate estimate = measure(pair, result, pixel, after_loss);
  length_ = estimate.length;
  carryOn(pair, result, pixel, length_);
  return estimate;
}

void ScalePropagator::carryThroughRotation(const Triangulation& pair, const MatchResult& result) {
  current_.assign(static_cast<size_t>(result.keypoints_current), InverseDepth());
  for (int i = 0; i < pair.size(); ++i) {
    const Match& match = result.matches[pair.row[i]];
    const auto keypoint = static_cast<size_t>(match.reference);
    if (keypoint >= reference_.size() || reference_[keypoint].variance == 0) continue;
    const InverseDepth& old = reference_[keypoint];
    // Depth of the point in the rotated camera over the old one.
    const Eigen::Vector3d ray(pair.x_reference[i], pair.y_reference[i], 1);
    const double stretch = (result.robust.judgement.pose.R.transpose() * ray).z();
    if (stretch <= 0) continue;
    current_[static_cast<size_t>(match.current)] = {old.value / stretch, old.variance / (stretch * stretch)};
  }
}

void ScalePropagator::advance() {
  reference_.swap(current_);
  current_.clear();
}

void ScalePropagator::reset() {
  reference_.clear();
  current_.clear();
  length_ = 1;
}

RelativePose withLength(const RelativePose& unit_pose, const ScaleEstimate& scale) {
  RelativePose pose = unit_pose;
  Eigen::Matrix<double, 6, 6> stretch = Eigen::Matrix<double, 6, 6>::Identity();
  stretch.topLeftCorner<3, 3>() *= scale.length;
  pose.covariance = stretch * unit_pose.covariance * stretch;
  const Eigen::Vector3d along = unit_pose.t * scale.length * scale.relative_sigma;
  pose.covariance.topLeftCorner<3, 3>() += along * along.transpose();
  pose.t = unit_pose.t * scale.length;
  return pose;
}

}  // namespace gms_ransac
