#include "judgement/match_probability.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

namespace gms_ransac {

namespace {

constexpr float kSquaredWindow = MatchNoise::kWindow * MatchNoise::kWindow;
constexpr float kRightWithin = 3;  ///< thresholds from its true place
/// Sigma of right keypoints with larger errors than most, such as a corner found on the next pixel: one threshold, or
/// twice the noise if that is more.
constexpr float kWideSigma = 1, kWideSigmas = 2;
constexpr float kFirstNear = 0.75f, kFirstWide = 0.05f;
constexpr int kShareIterations = 15;

/// Maps a column of numbers.
Eigen::Map<Eigen::ArrayXf> array(std::vector<float>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

}  // namespace

template <class Square, class Wrong, class Scale>
void MatchProbability::fit(int count, double sigma, const Square& square, const Wrong& wrong, const Scale& scale) {
  within_.clear();
  within_.reserve(static_cast<size_t>(count));
  for (auto* column : {&squares_, &near_density_, &wide_density_, &wrong_density_, &near_, &wide_}) {
    column->clear();
    column->reserve(static_cast<size_t>(count));  // for all of them, so that how many lie within allocates nothing
  }
  for (int i = 0; i < count; ++i) {
    const float residual = square(static_cast<size_t>(i));
    if (!(residual < kSquaredWindow)) continue;
    within_.push_back(i);
    squares_.push_back(residual);
    wrong_density_.push_back(wrong(static_cast<size_t>(i)));
  }
  for (auto* column : {&near_density_, &wide_density_, &near_, &wide_}) column->resize(within_.size());
  near_sigma_ = static_cast<float>(sigma);
  wide_sigma_ = std::max(kWideSigma, kWideSigmas * near_sigma_);
  const auto density = [&](float deviation) {
    return scale(deviation) * (-0.5f / (deviation * deviation) * array(squares_)).exp();
  };
  auto near_density = array(near_density_), wide_density = array(wide_density_), wrong_density = array(wrong_density_);
  auto near = array(near_), wide = array(wide_);
  near_density = density(near_sigma_);
  wide_density = density(wide_sigma_);
  // The share of each component, by expectation and maximisation on a part of the matches.
  float near_share = kFirstNear, wide_share = kFirstWide;
  const auto weigh = [&](Eigen::Index matches) {
    // `wide` holds what all components say together until it is known.
    const float wrong_share = std::max(MatchNoise::kLeastWrong, 1 - near_share - wide_share);
    wide.head(matches) = near_share * near_density.head(matches) + wide_share * wide_density.head(matches) +
                         wrong_share * wrong_density.head(matches);
    near.head(matches) = near_share * near_density.head(matches) / wide.head(matches);
    wide.head(matches) = wide_share * wide_density.head(matches) / wide.head(matches);
  };
  const Eigen::Index fitted = std::min<Eigen::Index>(near.size(), 2 * kRandomPart);
  for (int iteration = 0; iteration < kShareIterations && fitted > 0; ++iteration) {
    weigh(fitted);
    const float last = std::exchange(near_share, near.head(fitted).sum() / static_cast<float>(fitted));
    wide_share = wide.head(fitted).sum() / static_cast<float>(fitted);
    if (std::abs(near_share - last) < MatchNoise::kSettled) break;
  }
  weigh(near.size());
}

const std::vector<float>& MatchProbability::weigh(const MatchNoise& noise, const std::vector<uint8_t>& apart,
                                                  const PointColumnsView& points, float finest_weight) {
  probabilities_.assign(static_cast<size_t>(points.count), 0.f);
  for (const bool other : {false, true}) {
    if (other && apart.empty()) break;
    // The parallaxes that another motion should have are unknown.
    fit(
        points.count, noise.sigma(),
        [&](size_t i) { return apart.empty() || apart[i] == other ? noise.residuals()[i] : kSquaredWindow; },
        [&](size_t i) { return (other ? 1.f : noise.odds()[i]) / MatchNoise::kWindow; },
        [](float sigma) { return static_cast<float>(std::sqrt(2 / M_PI)) / sigma; });
    for (size_t k = 0; k < within_.size(); ++k) {
      // The residual is that of either keypoint: across the line the two are sqrt(2) as far apart, and as much noise is
      // along it, which cannot be seen.
      const float stretch = finest_weight / points.weight[within_[k]];
      const float left = kRightWithin * kRightWithin - 2 * squares_[k] * stretch;
      if (!(left > 0)) continue;
      const float reach = 0.5f * std::sqrt(left / stretch);
      probabilities_[static_cast<size_t>(within_[k])] =
          std::min(1.f, near_[k] * std::erf(reach / near_sigma_) + wide_[k] * std::erf(reach / wide_sigma_));
    }
  }
  return probabilities_;
}

const std::vector<float>& MatchProbability::weighRotated(const MatchNoise& noise,
                                                         const std::vector<float>& rotation_residuals,
                                                         const PointColumnsView& points, float finest_weight) {
  probabilities_.assign(static_cast<size_t>(points.count), 0.f);
  // A transfer distance has the noise of both images.
  fit(
      points.count, noise.sigma(), [&](size_t i) { return 0.5f * rotation_residuals[i]; },
      [](size_t) { return 1 / kSquaredWindow; }, [](float sigma) { return 0.5f / (sigma * sigma); });
  for (size_t k = 0; k < within_.size(); ++k) {
    const float stretch = finest_weight / points.weight[within_[k]];
    const bool is_close = 2 * squares_[k] * stretch < kRightWithin * kRightWithin;
    if (is_close) probabilities_[static_cast<size_t>(within_[k])] = std::min(1.f, near_[k] + wide_[k]);
  }
  return probabilities_;
}

}  // namespace gms_ransac
