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
  /// Probability of each column, from the measured noise, residuals and parallaxes. `apart`: flags of the columns that
  /// follow another motion, or empty; `finest_weight`: the weight of columns with keypoints of the finest level. Valid
  /// until the next call.
  const std::vector<float>& weigh(const MatchNoise& noise, const std::vector<uint8_t>& apart,
                                  const PointColumnsView& points, float finest_weight);
  /// The same if the camera only rotated: the rotation predicts the point of each match and not only its line.
  /// `rotation_residuals`: squared transfer distance of each column under the rotation.
  const std::vector<float>& weighRotated(const MatchNoise& noise, const std::vector<float>& rotation_residuals,
                                         const PointColumnsView& points, float finest_weight);

 private:
  /// Fits the components to the matches of some residuals, those within the window, and fills their probabilities.
  /// `on_line`: the residual is the distance from a line; `square(i)`, `wrong(i)`: squared residual of a match and its
  /// density if it is wrong; `scale`: of the density of a squared residual whose standard deviation is the argument.
  template <class Square, class Wrong, class Scale>
  void fit(const PointColumnsView& points, const MatchNoise& noise, float finest_weight, bool on_line,
           const Square& square, const Wrong& wrong, const Scale& scale);

  std::vector<int> within_;  ///< columns within the window
  enum { kSquare, kWrongDensity, kNearDensity, kWideDensity, kNear, kWide, kCount };
  AlignedColumns densities_;  ///< theirs, the last two posteriors
  std::vector<float> probabilities_;
};

}  // namespace gms_ransac
