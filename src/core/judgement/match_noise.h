// Noise of the matches of a pair, estimated without the threshold that selected the inliers, and the probability that
// each match belongs to it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "two_view/pose_model.h"

namespace gms_ransac {

/// The matches under a pose as a mixture; lengths in thresholds. Residuals of right matches are normal, and their
/// parallaxes (what the rotation leaves of the displacement) spread about a typical one. Residuals of wrong matches are
/// even up to kWindow; half of these matches end anywhere in the image, so that those which hit their epipolar line by
/// chance have mostly more parallax than the scene. Derived in doc/judgement.md.
class MatchNoise {
 public:
  static constexpr float kWindow = 5;          ///< a residual beyond it is a wrong match's
  static constexpr float kLeastWrong = 1e-3f;  ///< share of wrong matches
  static constexpr float kSettled = 1e-3f;     ///< a step at which a fit ends, far below what it is known to
  static constexpr int kMostIterations = 15;

  /// Fits the mixture to the matches under a pose, by expectation and maximisation (Dempster, Laird & Rubin 1977).
  /// `apart`: flags of the columns that are known to belong to something else, or empty.
  void measure(const PoseModel& model, const TwoViewPose& pose, const std::vector<uint8_t>& apart = {});
  /// The same where no pose is known: squared residuals of `count` matches alone.
  void measure(const std::vector<float>& squared_residuals, int count);

  /// Standard deviation of a right match's signed residual, which for the Sampson distance is that of a keypoint's
  /// coordinates.
  double sigma() const { return sigma_; }
  /// Standard deviation for keypoints with larger errors than most, such as a corner found on the next pixel: one
  /// threshold, or twice the noise if that is more.
  double wideSigma() const { return std::max(1.0, kWideSigmas * sigma_); }
  /// Converts squared residuals, times `share`, to residuals in standard deviations.
  void toDeviations(double share, std::vector<float>& squared) const {
    for (float& e : squared) e = std::sqrt(static_cast<float>(share) * e) / static_cast<float>(sigma_);
  }
  /// Squared residual of each column, padding included.
  const std::vector<float>& residuals() const { return residuals_; }
  /// Posterior probability of each column to belong to the inlier component. MatchProbability is the published one.
  const std::vector<float>& probabilities() const { return probabilities_; }
  /// How much likelier the parallax of each column is for a wrong match; 1 where no pose is known.
  const std::vector<float>& odds() const { return odds_; }
  /// Returns false if the parallax of a match is far likelier for a wrong match, even if it lies on its epipolar line.
  /// One such match can outweigh hundreds of others in the direction of translation.
  bool plausible(int column) const { return odds_[static_cast<size_t>(column)] < kMostOdds; }

  /// A loss as wide as wideSigma(), and so no narrower than that of the search. Its optimum is nearly that of least
  /// squares.
  Loss loss() const;

 private:
  static constexpr float kMostOdds = 5;
  static constexpr double kWideSigmas = 2;

  void weighParallaxes(int count, float reach);
  void fit(int count);

  double sigma_ = 1;
  std::vector<float> residuals_, parallaxes_, probabilities_;
  std::vector<float> odds_;  ///< how much likelier the parallax is for a wrong match
  std::vector<float> octaves_;
  std::vector<int> within_;  ///< columns within the window
  AlignedColumns near_;      ///< their residuals, odds and probabilities
};

}  // namespace gms_ransac
