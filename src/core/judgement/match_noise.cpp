#include "judgement/match_noise.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

constexpr int kIterations = 8;
constexpr double kFirstSigma = 0.5, kFirstShare = 0.8;
constexpr double kSmallestSigma = 0.02;  ///< coordinates are rounded to about that
constexpr double kLargestShare = 1 - 1e-3;
constexpr float kLeastParallax = 0.01f;    ///< squared; below it is noise
constexpr double kNarrowestSpread = 0.25;  ///< of the parallaxes, octaves
constexpr float kImageExtent = 2;          ///< longest displacement that an image allows, focal lengths
constexpr double kSoftnessSigmas =
    2;  ///< softness of the loss; at 1 or more the optimum is nearly that of least squares

}  // namespace

void MatchNoise::measure(const PoseModel& model, const PointColumnsView& points, const TwoViewPose& pose,
                         int64_t& evaluations) {
  residuals_.resize(static_cast<size_t>(points.size));
  parallaxes_.resize(residuals_.size());
  model.residuals(pose, residuals_.data());
  model.rotationResiduals(pose.R, parallaxes_.data());
  evaluations += 2 * static_cast<int64_t>(points.count);
  weighParallaxes(points.count, points.count > 0 ? kImageExtent * std::sqrt(points.weight[0]) : 1);
  fit(points.count);
}

void MatchNoise::measure(const std::vector<float>& squared_residuals, int count) {
  residuals_ = squared_residuals;
  odds_.assign(static_cast<size_t>(count), 1.f);
  fit(count);
}

Loss MatchNoise::loss() const {
  const auto softness = static_cast<float>(std::max(1.0, kSoftnessSigmas * kSoftnessSigmas * sigma_ * sigma_));
  return {4 * softness, 1 / softness};
}

void MatchNoise::weighParallaxes(int count, float reach) {
  odds_.resize(static_cast<size_t>(count));
  octaves_.clear();
  for (size_t i = 0; i < odds_.size(); ++i) {
    odds_[i] = 0.5f * std::log2(std::max(parallaxes_[i], kLeastParallax));
    if (residuals_[i] < 1) octaves_.push_back(odds_[i]);
  }
  if (octaves_.empty()) return odds_.assign(odds_.size(), 1.f);
  const auto quantile = [&](double share) {
    const auto place = octaves_.begin() + static_cast<int>(share * static_cast<double>(octaves_.size() - 1));
    std::nth_element(octaves_.begin(), place, octaves_.end());
    return static_cast<double>(*place);
  };
  const double middle = quantile(0.5);
  const double spread = std::max(kNarrowestSpread, 0.5 * (quantile(0.84) - quantile(0.16)));
  // Laplace's distribution of the logarithm: tails, but falling ones.
  const auto slope = static_cast<float>(M_SQRT2 / spread), centre = static_cast<float>(middle);
  const auto scale = static_cast<float>(0.5 * M_LN2 * M_SQRT2 * spread) / reach;
  for (float& odds : odds_) {
    const float parallax_over_density = std::exp(odds * static_cast<float>(M_LN2) + slope * std::abs(odds - centre));
    odds = 0.5f + scale * parallax_over_density;
  }
}

void MatchNoise::fit(int count) {
  constexpr float kSquaredWindow = kWindow * kWindow;
  probabilities_.assign(static_cast<size_t>(count), 0.f);
  sigma_ = kFirstSigma;
  double share = kFirstShare;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    double right = 0, squares = 0, within = 0;
    const auto exponent = static_cast<float>(-0.5 / (sigma_ * sigma_));
    const auto wrong = static_cast<float>((1 - share) / kWindow / (share * std::sqrt(2 / M_PI) / sigma_));
    for (size_t i = 0; i < probabilities_.size(); ++i) {
      const float e = residuals_[i];
      if (!(e < kSquaredWindow)) continue;
      const float normal = std::exp(exponent * e), probability = normal / (normal + wrong * odds_[i]);
      probabilities_[i] = probability;
      right += static_cast<double>(probability);
      squares += static_cast<double>(probability * e);
      ++within;
    }
    if (!(right > 0)) return;
    sigma_ = std::max(kSmallestSigma, std::sqrt(squares / right));
    share = std::min(right / within, kLargestShare);
  }
}

}  // namespace gms_ransac
