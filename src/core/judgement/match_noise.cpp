#include "judgement/match_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "order_statistics.h"

namespace gms_ransac {

namespace {

constexpr double kFirstSigma = 0.5, kFirstShare = 0.8;
constexpr float kSmallestSigma = 0.02f;    ///< coordinates are rounded to about that, and so are parallaxes
constexpr float kNarrowestSpread = 0.25f;  ///< of the parallaxes, octaves
constexpr float kImageExtent = 2;          ///< longest displacement that an image allows, focal lengths

constexpr auto kLn2 = static_cast<float>(M_LN2), kRoot2 = static_cast<float>(M_SQRT2);
constexpr float kHalfLog2 = 0.5f / kLn2;  ///< of the natural logarithm of a square, octaves

/// 16, 50 and 84 % quantiles: middle and one deviation to either side. Rearranges the values.
std::array<float, 3> quantiles(std::vector<float>& values) {
  const auto last = static_cast<double>(values.size() - 1);
  const auto quantile = [&](double share) { return nthSmallest(values, static_cast<size_t>(share * last)); };
  return {quantile(0.16), quantile(0.5), quantile(0.84)};
}

}  // namespace

void MatchNoise::measure(const PoseModel& model, const TwoViewPose& pose, const std::vector<uint8_t>& apart) {
  const PointColumnsView& points = model.points();
  model.residuals(pose, residuals_);
  model.rotationResiduals(pose.R, parallaxes_);
  weighParallaxes(points.count, points.count > 0 ? kImageExtent * std::sqrt(points.weight[0]) : 1);
  for (size_t i = 0; i < apart.size(); ++i) {
    if (apart[i]) odds_[i] = std::max(odds_[i], 1 / kLeastWrong);
  }
  fit(points.count);
}

void MatchNoise::measure(const std::vector<float>& squared_residuals, int count) {
  residuals_ = squared_residuals;
  odds_.assign(static_cast<size_t>(count), 1.f);
  fit(count);
}

Loss MatchNoise::loss() const {
  const auto softness = static_cast<float>(wideSigma() * wideSigma());
  return {4 * softness, 1 / softness};
}

void MatchNoise::weighParallaxes(int count, float reach) {
  const auto size = static_cast<Eigen::Index>(count);
  odds_.resize(static_cast<size_t>(count));
  Eigen::Map<Eigen::ArrayXf> odds(odds_.data(), size);
  odds =
      kHalfLog2 * Eigen::Map<const Eigen::ArrayXf>(parallaxes_.data(), size).max(kSmallestSigma * kSmallestSigma).log();
  octaves_.clear();
  for (size_t i = 0; i < odds_.size(); ++i) {
    if (residuals_[i] < 1) octaves_.push_back(odds_[i]);
  }
  if (octaves_.empty()) return odds_.assign(odds_.size(), 1.f);
  const auto [low, centre, high] = quantiles(octaves_);
  const float spread = std::max(kNarrowestSpread, 0.5f * (high - low));
  // Laplace's distribution of the logarithm: tails, but falling ones.
  const float slope = kRoot2 / spread, scale = 0.5f * kLn2 * kRoot2 * spread / reach;
  odds = 0.5f + scale * (kLn2 * odds + slope * (odds - centre).abs()).exp();
}

void MatchNoise::fit(int count) {
  constexpr float kSquaredWindow = kWindow * kWindow;
  within_.clear();
  within_.reserve(residuals_.size());  // so that how many lie within allocates nothing
  near_.resize(3, count);
  for (int i = 0; i < count; ++i) {
    const auto column = static_cast<size_t>(i);
    if (!(residuals_[column] < kSquaredWindow)) continue;
    near_.column(0)[within_.size()] = residuals_[column];
    near_.column(1)[within_.size()] = odds_[column];
    within_.push_back(i);
  }
  const auto within = static_cast<Eigen::Index>(within_.size());
  const Eigen::Map<const Eigen::ArrayXf> e(near_.column(0), within), odds(near_.column(1), within);
  Eigen::Map<Eigen::ArrayXf> probability(near_.column(2), within);
  sigma_ = kFirstSigma;
  double share = kFirstShare;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const auto exponent = static_cast<float>(-0.5 / (sigma_ * sigma_));
    const auto wrong = static_cast<float>((1 - share) / kWindow / (share * std::sqrt(2 / M_PI) / sigma_));
    probability = (exponent * e).exp();
    probability /= probability + wrong * odds;
    const auto right = static_cast<double>(probability.sum());
    const auto squares = static_cast<double>((probability * e).sum());
    if (!(right > 0)) break;
    const double last = std::exchange(sigma_, std::max<double>(kSmallestSigma, std::sqrt(squares / right)));
    if (std::abs(sigma_ - last) < kSettled * sigma_) break;
    share = std::min(right / static_cast<double>(within), 1. - kLeastWrong);
  }
  probabilities_.assign(static_cast<size_t>(count), 0.f);
  for (Eigen::Index k = 0; k < within; ++k) probabilities_[static_cast<size_t>(within_[k])] = probability[k];
}

}  // namespace gms_ransac
