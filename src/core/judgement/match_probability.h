// With what probability each match is right: what whoever uses the matches is told.
#pragma once

#include <vector>

#include "judgement/match_noise.h"
#include "two_view/kernels/point_columns.h"

namespace gms_ransac {

/// A match is right when its points are within three thresholds of one another's true places. MatchNoise asks another
/// question, what belongs to the noise of most matches: a keypoint that was found a pixel off its corner does not, but
/// is right. Derived in doc/uncertainty.md.
class MatchProbability {
 public:
  /// Of each column, by the noise, residuals and parallaxes that were measured. `finest_weight`: that of columns whose
  /// keypoints are of the finest level. Valid until the next call.
  const std::vector<float>& weigh(const MatchNoise& noise, const PointColumnsView& points, float finest_weight);

 private:
  /// Densities of the matches within the window under each component, one column after the other.
  void collect(const MatchNoise& noise, int count);
  /// The share of each component, by expectation and maximisation; fills near_ and wide_ with the posteriors.
  void fitShares();

  std::vector<int> within_;  ///< columns within the window
  std::vector<float> squares_;
  std::vector<float> near_density_, wide_density_, wrong_density_;
  std::vector<float> near_, wide_;  ///< posteriors
  std::vector<float> probabilities_;
  float near_sigma_ = 1, wide_sigma_ = 1;
};

}  // namespace gms_ransac
