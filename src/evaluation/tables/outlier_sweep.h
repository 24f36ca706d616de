// How each method's estimator holds out against outliers, on correspondences of the rendered scene with exact labels.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

/// A trial counts as a success when the rotation and the direction of translation come this close to the truth: what a
/// method reaches without outliers in the least favourable of its repetitions, several times over.
constexpr double kSweepRotationLimit = 1, kSweepDirectionLimit = 5;  ///< degrees

struct OutlierSweepOptions {
  std::vector<std::string> methods;  ///< empty: every one
  RobustOptions robust;
  int matches = 1000;  ///< per trial
  double noise = 0.5;  ///< standard deviation of the current points, pixels
  int repeat = 50;     ///< trials per method and outlier ratio, each with its own matches and seed

  /// Throws std::invalid_argument with a sentence that names the field, its value and its range.
  void validate() const;
};

/// One method at one outlier ratio; medians over the trials.
struct OutlierSweepRow {
  std::string method;
  double outlier_ratio = 0;
  int trials = 0, successes = 0;
  double hypotheses = 0, models_scored = 0, point_evaluations = 0, milliseconds = 0;
  double precision = 0, recall = 0;  ///< of the inliers, by the true labels
};

/// Outlier ratios of 0.1 to 0.9. The filter stage is left out, so that the ratio is the one the estimator meets; the
/// motion statistics still give the score by which methods order. Methods that differ in the filter alone come out
/// equal. `advance` is called after every trial of every method.
std::vector<OutlierSweepRow> sweepOutliers(const OutlierSweepOptions& options, const std::function<void()>& advance);

/// Trials times methods times ratios: how often `advance` will be called.
int sweepLength(const OutlierSweepOptions& options);

}  // namespace gms_ransac
