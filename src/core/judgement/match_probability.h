// The probability that each match is right, as published.
#pragma once

#include <cstdint>
#include <vector>

#include "judgement/match_noise.h"
#include "two_view/kernels/point_columns.h"

namespace gms_ransac {

/// A match is right if its points are within three thresholds of each other's true places. MatchNoise has a narrower
/// definition, the noise of most matches: a keypoint found a pixel from its corner is right but not part of it. Derived
/// in doc/judgement.md.
class MatchProbability {
 public:
  /// Of each column, by the noise, residuals and parallaxes that were measured. `apart`: flags of the columns that
  /// follow another motion, or empty; `finest_weight`: that of columns whose keypoints are of the finest level. Valid
  /// until the next call.
  const std::vector<float>& weigh(const MatchNoise& noise, const std::vector<uint8_t>& apart,
                                  const PointColumnsView& points, float finest_weight);
  /// The same where the camera only turned, which says of each match where it ends and not only on which line.
  /// `rotation_residuals`: squared transfer distance of each column under the turn.
  const std::vector<float>& weighTurned(const MatchNoise& noise, const std::vector<float>& rotation_residuals,
                                        const PointColumnsView& points, float finest_weight);

 private:
  /// Fits the components to the matches of some residuals, those within the window, and fills near_ and wide_ with the
  /// posteriors. `square(i)`, `wrong(i)`: squared residual of a match and its density if it is wrong; `scale`: of the
  /// density of a squared residual whose standard deviation is the argument.
  template <class Square, class Wrong, class Scale>
  void fit(int count, double sigma, const Square& square, const Wrong& wrong, const Scale& scale);

  std::vector<int> within_;  ///< columns within the window
  std::vector<float> squares_;
  std::vector<float> near_density_, wide_density_, wrong_density_;
  std::vector<float> near_, wide_;  ///< posteriors
  std::vector<float> probabilities_;
  float near_sigma_ = 1, wide_sigma_ = 1;
};

}  // namespace gms_ransac
