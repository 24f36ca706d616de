// Noise of the matches of a pair, estimated without the threshold that selected the inliers, and the probability that
// each match is right. Derived in doc/inside/judgement.md.
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
/// chance have mostly more parallax than the scene. Keeps its storage.
class MatchNoise {
 public:
  static constexpr float kWindow = 5;  ///< a residual beyond it is a wrong match's

  explicit MatchNoise(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// Fits the mixture to the matches under a pose, by expectation and maximisation (Dempster, Laird & Rubin 1977).
  /// `of_other`: flags of the slots that are known to belong to something else, or empty.
  void measure(const PoseModel& model, const TwoViewPose& pose, const std::vector<uint8_t>& of_other = {});
  /// The same where no pose is known: squared residuals of `count` matches alone.
  void measure(const std::vector<float>& squared_residuals, int count);

  /// Standard deviation of a right match's signed residual, which for the Sampson distance is that of a keypoint's
  /// coordinates.
  double sigma() const { return sigma_; }
  double variance() const { return sigma_ * sigma_; }
  /// Converts squared residuals, times `share`, to residuals in standard deviations.
  void toDeviations(double share, std::vector<float>& squared) const {
    for (float& e : squared) e = std::sqrt(static_cast<float>(share) * e) / static_cast<float>(sigma_);
  }
  /// Squared residual of each slot, padding included.
  const std::vector<float>& residuals() const { return residuals_; }
  /// Posterior probability of each slot to belong to the inlier component; `weigh` has the published one.
  const std::vector<float>& probabilities() const { return probabilities_; }
  /// Returns false if the parallax of a match is far likelier for a wrong match, even if it lies on its epipolar line.
  /// One such match can outweigh hundreds of others in the direction of translation.
  bool plausible(int slot) const { return odds_[static_cast<size_t>(slot)] < kMostOdds; }
  /// A loss with a softness of two deviations of the noise. Its optimum is nearly that of least squares.
  Loss loss() const;

  /// The probability that each slot is right: its points are within three thresholds of each other's true places. A
  /// keypoint found a pixel from its corner is right but not part of the noise. `finest_weight`: the weight of slots
  /// with keypoints of the finest level; `of_other`: flags of the slots that follow another motion, or empty.
  /// `rotated`: if the camera only rotated, which predicts the point of each match and not only its line, the squared
  /// transfer distance of each slot. Valid until the next call.
  const std::vector<float>& weigh(const PointColumnsView& points, float finest_weight,
                                  const std::vector<uint8_t>& of_other = {},
                                  const std::vector<float>* rotated = nullptr) const;

 private:
  static constexpr float kMostOdds = 5;

  /// Standard deviation for keypoints with larger errors than most, such as a corner found on the next pixel.
  double wideSigma() const;
  void weighParallaxes(const PointColumnsView& points);
  void fit(int count);
  /// Fits the shares of noise, wide noise and wrong matches to the slots whose residuals were gathered, with their
  /// densities if they are wrong, and fills their probabilities. `on_line`: residuals are distances from a line.
  void fitShares(const PointColumnsView& points, float finest_weight, bool on_line) const;
  /// Gathers the slots whose residual is within the window: square(slot) and what a wrong match has in its place,
  /// wrong(slot).
  template <class Square, class Wrong>
  void gather(int count, const Square& square, const Wrong& wrong) const;

  const ResidualKernels& kernels_;
  double sigma_ = 1;
  std::vector<float> residuals_, parallaxes_, probabilities_, octaves_;
  std::vector<float> odds_;  ///< how much likelier the parallax is for a wrong match; 1 where no pose is known
  // Storage of one call: answers, slots within the window, and their columns.
  mutable std::vector<float> right_;
  mutable std::vector<int> within_;
  enum { kSquare, kWrong, kNearDensity, kWideDensity, kNear, kWide, kReach, kColumns };
  mutable AlignedColumns near_;  ///< squared residuals, how likely they are for each component, posteriors
};

}  // namespace gms_ransac
