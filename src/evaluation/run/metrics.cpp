#include "run/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

namespace gms_ransac {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kZeroLength = 1e-12;  // a translation this short has no direction

double degrees(double cosine) { return std::acos(std::min(1.0, std::max(-1.0, cosine))) * 180.0 / M_PI; }

}  // namespace

PoseError poseError(const Eigen::Isometry3d& truth, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  PoseError error;
  error.rotation = degrees(((truth.linear().transpose() * R).trace() - 1) / 2);
  const double length = t.norm(), true_length = truth.translation().norm();
  error.direction = length < kZeroLength ? 90.0 : degrees(t.dot(truth.translation()) / (length * true_length + 1e-15));
  return error;
}

double areaUnderRecallCurve(std::vector<double> errors, double threshold) {
  std::sort(errors.begin(), errors.end());
  const double n = static_cast<double>(errors.size());
  double area = 0, last_error = 0, last_recall = 0;
  for (size_t i = 0; i < errors.size() && errors[i] < threshold; ++i) {
    const double recall = static_cast<double>(i + 1) / n;
    area += 0.5 * (last_recall + recall) * (errors[i] - last_error);
    last_error = errors[i];
    last_recall = recall;
  }
  area += last_recall * (threshold - last_error);
  return 100.0 * area / threshold;
}

double percentile(std::vector<double> values, double percent) {
  if (values.empty()) return kNone;
  std::sort(values.begin(), values.end());
  const double position = percent / 100.0 * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - static_cast<double>(below)) * (values[above] - values[below]);
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return kNone;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Spread spread(const std::vector<double>& values) {
  return {percentile(values, 50), percentile(values, 10), percentile(values, 90)};
}

double paperPrecision(double kept, double gms_survivors) {
  return gms_survivors > 0 ? 100.0 * kept / gms_survivors : kNone;
}

double paperRecall(double kept, double preset_features) { return 100.0 * kept / preset_features; }

double reduction(double base, double ours) { return 100.0 * (base - ours) / base; }

PairedDifference bootstrapOverPairs(size_t pairs, const PairFigure& figure, int resamples, uint64_t seed) {
  std::vector<size_t> picks(pairs);
  std::iota(picks.begin(), picks.end(), size_t{0});
  PairedDifference result{figure(picks), kNone, kNone};
  if (pairs == 0) return result;
  std::mt19937_64 random(seed);
  std::vector<double> figures;
  for (int round = 0; round < resamples; ++round) {
    for (size_t& pick : picks) pick = random() % pairs;
    figures.push_back(figure(picks));
  }
  result.low = percentile(figures, 2.5);
  result.high = percentile(figures, 97.5);
  return result;
}

PairedDifference pairedBootstrap(const std::vector<double>& a, const std::vector<double>& b, const Statistic& statistic,
                                 int resamples, uint64_t seed) {
  if (a.size() != b.size()) throw std::invalid_argument("paired bootstrap: the two columns differ in length");
  std::vector<double> picked_a(a.size()), picked_b(b.size());
  const PairFigure difference = [&](const std::vector<size_t>& picks) {
    for (size_t i = 0; i < picks.size(); ++i) {
      picked_a[i] = a[picks[i]];
      picked_b[i] = b[picks[i]];
    }
    return statistic(picked_a) - statistic(picked_b);
  };
  return bootstrapOverPairs(a.size(), difference, resamples, seed);
}

}  // namespace gms_ransac
