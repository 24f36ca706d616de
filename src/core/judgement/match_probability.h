// The probability that each match is right, as published.
#pragma once

#include <vector>

#include "judgement/match_noise.h"
#include "two_view/kernels/point_columns.h"

namespace gms_ransac {

/// A match is right if its points are within three thresholds of each other's true places. MatchNoise has a narrower
/// definition, the noise of most matches: a keypoint found a pixel from its corner is right but not part of it. Derived
/// in doc/judgement.md.
class MatchProbability {
 public:
  /// Probability of each column, from the measured noise, residuals and parallaxes. `finest_weight`: the weight of
  /// columns with keypoints of the finest level. Valid until the next call.
  const std::vector<float>& weigh(const MatchNoise& noise, const PointColumnsView& points, float finest_weight);
  /// The same if the camera only rotated: the rotation predicts the point of each match and not only its line.
  /// `rotation_residuals`: squared transfer distance of each column under the rotation.
  const std::vector<float>& weighTurned(const MatchNoise& noise, const std::vector<float>& rotation_residuals,
                                        const PointColumnsView& points, float finest_weight);

 private:
  /// Begins another set of matches; storage for `count` of them, so that how many there are allocates nothing.
  void clear(int count);
  /// Takes in a match by its squared residual and its density if it is wrong, where it lies within the window.
  void add(int column, float square, float wrong_density);
  /// Fits the components to the added matches and fills near_ and wide_ with the posteriors. `scale`: of the density
  /// of a squared residual whose standard deviation is the argument.
  template <class Scale>
  void fit(double sigma, const Scale& scale);
  /// The share of each component, by expectation and maximisation.
  void fitShares();
  /// For the matches of another motion, or for all others.
  void weighOnLines(const MatchNoise& noise, const PointColumnsView& points, float finest_weight, bool apart);

  std::vector<int> within_;  ///< columns within the window
  std::vector<float> squares_;
  std::vector<float> near_density_, wide_density_, wrong_density_;
  std::vector<float> near_, wide_;  ///< posteriors
  std::vector<float> probabilities_;
  float near_sigma_ = 1, wide_sigma_ = 1;
};

}  // namespace gms_ransac
