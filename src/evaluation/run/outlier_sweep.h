// How each method's estimator holds out against outliers, on correspondences of the rendered scene with exact labels.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "gms_ransac/robust_options.h"

namespace gms_ransac {

/// A trial is a success within these errors of rotation and direction, degrees: several times what a method reaches
/// without outliers in the least favourable of its repetitions.
constexpr double kSweepRotationLimit = 1, kSweepDirectionLimit = 5;

struct OutlierSweepOptions {
  std::vector<std::string> methods;  ///< empty: every one
  RobustOptions robust;
  int matches = 1000;  ///< per trial
  double noise = 0.5;  ///< standard deviation of the current points, pixels
  int repeat = 50;     ///< trials per method and outlier ratio, each with its own matches and seed

  /// Throws std::invalid_argument with a sentence that names the field, its value and its range.
  void validate() const;
};

/// A record of each trial, at outlier ratios of 0.1 to 0.9: method, outlier_ratio, success, effort, milliseconds, and
/// precision and recall by the true labels. There is no filter stage, so that the estimator meets that ratio; the
/// motion statistics give the score by which methods order. Methods that differ only in the filter have equal results.
void sweepOutliers(const OutlierSweepOptions& options, const std::function<void(const nlohmann::json&)>& receive);

/// Number of records.
int sweepLength(const OutlierSweepOptions& options);

}  // namespace gms_ransac
