// Estimates a motion from some of the matches, and makes it the answer of all.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "methods/method.h"

namespace gms_ransac {

constexpr float kExplained = 3;  ///< of the residual of a point that a motion explains

/// Adds the square of the step to another rotation, times the probability that it is the right one, to the covariance.
void widen(const Eigen::Matrix3d& other, double probability, RelativePose& pose);

/// Keeps its storage from pair to pair.
class SubsetEstimate {
 public:
  std::vector<int> rows;  ///< of the matches of the subset, to be filled by the caller
  RobustResult robust;    ///< their motion; entry n of its columns is that of rows[n]

  /// Estimates from `rows` alone; the effort is added to that of `result`.
  void estimate(Method& method, const Camera& camera, MatchResult& result);
  /// The estimate finds no motion.
  void clear() { robust.clear(); }
  /// Residuals of all matches, standard deviations: of the model, or of the rotation where the direction is unknown.
  const std::vector<float>& residuals(const Camera& camera, const PointPairs& all);
  /// Replaces the estimate of all matches by this one. The other matches are no inliers; those that the motion explains
  /// may be static, to the next pair.
  void replace(const Camera& camera, MatchResult& result);

 private:
  PointPairs pairs_;
  std::vector<uint8_t> inlier_;
  std::vector<float> probability_, residual_;
};

}  // namespace gms_ransac
