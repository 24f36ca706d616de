#include "judgement/match_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "support/order_statistics.h"

namespace gms_ransac {

namespace {

static_assert(!EIGEN_FAST_MATH, "square roots of columns would differ between processors");

constexpr float kSettled = 1e-3f;  ///< a step at which a fit ends, far below what it is known to
constexpr int kMostIterations = 15;
constexpr float kSquaredWindow = MatchNoise::kWindow * MatchNoise::kWindow;
constexpr float kLeastWrong = 1e-3f;       ///< share of wrong matches
constexpr float kSmallestSigma = 0.02f;    ///< coordinates are rounded to about that, and so are parallaxes
constexpr float kNarrowestSpread = 0.25f;  ///< of the parallaxes, octaves
constexpr double kLossSigmas = 2;          ///< of the noise, softness of the loss
constexpr double kWideSigmas = 2;          ///< of the noise; at least one threshold
constexpr float kRightWithin = 3;          ///< thresholds from its true place
constexpr float kTiny = 1e-18f;            ///< keeps the weight of padding above zero
constexpr float kImageExtent = 2;          ///< longest displacement that an image allows, focal lengths

constexpr auto kLn2 = static_cast<float>(M_LN2), kRoot2 = static_cast<float>(M_SQRT2);
constexpr float kHalfLog2 = 0.5f / kLn2;  ///< of the natural logarithm of a square, octaves

/// 16, 50 and 84 % quantiles: middle and one deviation to either side. Rearranges the values.
std::array<float, 3> quantiles(std::vector<float>& values) {
  const auto last = static_cast<double>(values.size() - 1);
  const auto place = [&](double share) { return static_cast<size_t>(share * last); };
  return smallest<3>(values, {place(0.16), place(0.5), place(0.84)});
}

}  // namespace

void MatchNoise::measure(const PoseModel& model, const TwoViewPose& pose, const std::vector<uint8_t>& of_other) {
  const PointColumnsView& points = model.points();
  model.residuals(pose, residuals_);
  model.rotationResiduals(pose.R, parallaxes_);
  weighParallaxes(points);
  for (size_t slot = 0; slot < of_other.size(); ++slot) {
    if (of_other[slot]) odds_[slot] = std::max(odds_[slot], 1 / kLeastWrong);
  }
  fit(points.count);
}

void MatchNoise::measure(const std::vector<float>& squared_residuals, int count) {
  residuals_ = squared_residuals;
  odds_.assign(static_cast<size_t>(count), 1.f);
  fit(count);
}

double MatchNoise::wideSigma() const { return std::max(1.0, kWideSigmas * sigma_); }

Loss MatchNoise::loss() const {
  const double deviation = kLossSigmas * sigma_;
  const auto softness = static_cast<float>(deviation * deviation);
  return {4 * softness, 1 / softness};
}

void MatchNoise::weighParallaxes(const PointColumnsView& points) {
  odds_.resize(parallaxes_.size());
  Eigen::Map<Eigen::ArrayXf> odds(odds_.data(), points.size);
  odds = Eigen::Map<const Eigen::ArrayXf>(parallaxes_.data(), points.size).max(kSmallestSigma * kSmallestSigma);
  kernels_.logarithm(odds_.data(), 1, points.size, odds_.data());
  octaves_.clear();
  for (size_t slot = 0; slot < static_cast<size_t>(points.count); ++slot) {
    if (residuals_[slot] < 1) octaves_.push_back(kHalfLog2 * odds_[slot]);
  }
  if (octaves_.empty()) return odds_.assign(odds_.size(), 1.f);
  const auto [low, centre, high] = quantiles(octaves_);
  const float spread = std::max(kNarrowestSpread, 0.5f * (high - low));
  // Laplace's distribution of the logarithm: tails, but falling ones. The thresholds of a match that an image is long:
  // kImageExtent times the root of its weight.
  const Eigen::Map<const Eigen::ArrayXf> weight(points.weight, points.size);
  const float slope = kRoot2 / spread, scale = 0.5f * kLn2 * kRoot2 * spread / kImageExtent;
  odds = 0.5f * odds + slope * (kHalfLog2 * odds - centre).abs();
  kernels_.exponential(odds_.data(), 1, points.size, odds_.data());
  odds = 0.5f + scale * odds / weight.max(kTiny).sqrt();
}

template <class Square, class Wrong>
void MatchNoise::gather(int count, const Square& square, const Wrong& wrong) const {
  within_.clear();
  within_.reserve(static_cast<size_t>(count));  // so that how many lie within allocates nothing
  near_.resize(kColumns, count);
  for (int slot = 0; slot < count; ++slot) {
    const float residual = square(static_cast<size_t>(slot));
    if (!(residual < kSquaredWindow)) continue;
    near_.column(kSquare)[within_.size()] = residual;
    near_.column(kWrong)[within_.size()] = wrong(static_cast<size_t>(slot));
    within_.push_back(slot);
  }
}

void MatchNoise::fit(int count) {
  gather(
      count, [this](size_t slot) { return residuals_[slot]; }, [this](size_t slot) { return odds_[slot]; });
  const auto within = static_cast<int>(within_.size());
  const Eigen::Map<const Eigen::ArrayXf> e(near_.column(kSquare), within), odds(near_.column(kWrong), within);
  Eigen::Map<Eigen::ArrayXf> probability(near_.column(kNear), within);
  sigma_ = 0.5;
  double share = 0.8;  // where the fit starts matters hardly
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const auto exponent = static_cast<float>(-0.5 / (sigma_ * sigma_));
    const auto wrong = static_cast<float>((1 - share) / kWindow / (share * std::sqrt(2 / M_PI) / sigma_));
    kernels_.exponential(e.data(), exponent, within, probability.data());
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

void MatchNoise::fitShares(const PointColumnsView& points, float finest_weight, bool on_line) const {
  const auto within = static_cast<int>(within_.size());
  const auto column = [&](int k) { return Eigen::Map<Eigen::ArrayXf>(near_.column(k), within); };
  auto squares = column(kSquare), wrong_density = column(kWrong), near = column(kNear), wide = column(kWide);
  auto near_density = column(kNearDensity), wide_density = column(kWideDensity), reach = column(kReach);
  const auto near_sigma = static_cast<float>(sigma_), wide_sigma = static_cast<float>(wideSigma());
  const auto density = [&](float deviation, Eigen::Map<Eigen::ArrayXf>& densities) {
    const float exponent = -0.5f / (deviation * deviation);
    kernels_.exponential(squares.data(), exponent, within, densities.data());
    densities *= on_line ? static_cast<float>(std::sqrt(2 / M_PI)) / deviation : -exponent;
  };
  density(near_sigma, near_density);
  density(wide_sigma, wide_density);
  // The share of each component, by expectation and maximisation on a part of the matches.
  float near_share = 0.75f, wide_share = 0.05f;  // where that starts matters hardly
  const auto weigh = [&](Eigen::Index matches) {
    // `wide` holds what all components say together until it is known.
    const float wrong_share = std::max(kLeastWrong, 1 - near_share - wide_share);
    wide.head(matches) = near_share * near_density.head(matches) + wide_share * wide_density.head(matches) +
                         wrong_share * wrong_density.head(matches);
    near.head(matches) = near_share * near_density.head(matches) / wide.head(matches);
    wide.head(matches) = wide_share * wide_density.head(matches) / wide.head(matches);
  };
  const Eigen::Index fitted = std::min<Eigen::Index>(near.size(), 2 * kRandomPart);
  for (int iteration = 0; iteration < kMostIterations && fitted > 0; ++iteration) {
    weigh(fitted);
    const float last = std::exchange(near_share, near.head(fitted).sum() / static_cast<float>(fitted));
    wide_share = wide.head(fitted).sum() / static_cast<float>(fitted);
    if (std::abs(near_share - last) < kSettled) break;
  }
  weigh(near.size());
  // How far the places may differ along the line. The residual is that of either keypoint: the two are sqrt(2) as far
  // apart. As much noise as across an epipolar line is along it, which cannot be seen.
  for (Eigen::Index k = 0; k < near.size(); ++k) reach[k] = points.weight[within_[static_cast<size_t>(k)]];
  reach = 0.5f * (kRightWithin * kRightWithin / finest_weight * reach - 2.f * squares).max(0.f).sqrt();
  if (on_line) {
    kernels_.errorFunction(reach.data(), 1 / near_sigma, within, near_density.data());
    kernels_.errorFunction(reach.data(), 1 / wide_sigma, within, wide_density.data());
    near *= near_density;
    wide *= wide_density;
  }
  for (Eigen::Index k = 0; k < near.size(); ++k) {
    if (reach[k] > 0) right_[static_cast<size_t>(within_[static_cast<size_t>(k)])] = std::min(1.f, near[k] + wide[k]);
  }
}

const std::vector<float>& MatchNoise::weigh(const PointColumnsView& points, float finest_weight,
                                            const std::vector<uint8_t>& of_other,
                                            const std::vector<float>* rotated) const {
  right_.assign(static_cast<size_t>(points.count), 0.f);
  if (rotated != nullptr) {
    // A transfer distance has the noise of both images.
    gather(
        points.count, [&](size_t slot) { return 0.5f * (*rotated)[slot]; }, [](size_t) { return 1 / kSquaredWindow; });
    fitShares(points, finest_weight, false);
    return right_;
  }
  for (const bool other : {false, true}) {
    if (other && of_other.empty()) break;
    // The parallaxes that another motion should have are unknown.
    gather(
        points.count,
        [&](size_t slot) { return of_other.empty() || of_other[slot] == other ? residuals_[slot] : kSquaredWindow; },
        [&](size_t slot) { return (other ? 1.f : odds_[slot]) / kWindow; });
    fitShares(points, finest_weight, true);
  }
  return right_;
}

}  // namespace gms_ransac
