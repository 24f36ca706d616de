#include "judgement/match_probability.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

namespace gms_ransac {

namespace {

constexpr float kSquaredWindow = MatchNoise::kWindow * MatchNoise::kWindow;
constexpr float kRightWithin = 3;  ///< thresholds from its true place
constexpr float kFirstNear = 0.75f, kFirstWide = 0.05f;

/// The error function, which is 1 for a float from 4 on.
float within(float deviations) { return deviations < 4 ? std::erf(deviations) : 1.f; }

}  // namespace

template <class Square, class Wrong, class Scale>
void MatchProbability::fit(const PointColumnsView& points, const MatchNoise& noise, float finest_weight, bool on_line,
                           const Square& square, const Wrong& wrong, const Scale& scale) {
  densities_.resize(kCount, points.count);
  within_.clear();
  within_.reserve(static_cast<size_t>(points.count));  // so that how many lie within allocates nothing
  for (int i = 0; i < points.count; ++i) {
    const float residual = square(static_cast<size_t>(i));
    if (!(residual < kSquaredWindow)) continue;
    densities_.column(kSquare)[within_.size()] = residual;
    densities_.column(kWrongDensity)[within_.size()] = wrong(static_cast<size_t>(i));
    within_.push_back(i);
  }
  const auto column = [&](int k) { return Eigen::Map<Eigen::ArrayXf>(densities_.column(k), within_.size()); };
  auto squares = column(kSquare), wrong_density = column(kWrongDensity), near = column(kNear), wide = column(kWide);
  auto near_density = column(kNearDensity), wide_density = column(kWideDensity);
  const auto near_sigma = static_cast<float>(noise.sigma()), wide_sigma = static_cast<float>(noise.wideSigma());
  const auto density = [&](float deviation) {
    return scale(deviation) * (-0.5f / (deviation * deviation) * squares).exp();
  };
  near_density = density(near_sigma);
  wide_density = density(wide_sigma);
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
  for (int iteration = 0; iteration < MatchNoise::kMostIterations && fitted > 0; ++iteration) {
    weigh(fitted);
    const float last = std::exchange(near_share, near.head(fitted).sum() / static_cast<float>(fitted));
    wide_share = wide.head(fitted).sum() / static_cast<float>(fitted);
    if (std::abs(near_share - last) < MatchNoise::kSettled) break;
  }
  weigh(near.size());
  for (Eigen::Index k = 0; k < near.size(); ++k) {
    const int column = within_[static_cast<size_t>(k)];
    // The residual is that of either keypoint: the two are sqrt(2) as far apart.
    const float stretch = finest_weight / points.weight[column];
    const float left = kRightWithin * kRightWithin - 2 * squares[k] * stretch;
    if (!(left > 0)) continue;
    // As much noise as across an epipolar line is along it, which cannot be seen.
    const float reach = 0.5f * std::sqrt(left / stretch);
    const auto inside = [&](float sigma) { return on_line ? within(reach / sigma) : 1.f; };
    probabilities_[static_cast<size_t>(column)] =
        std::min(1.f, near[k] * inside(near_sigma) + wide[k] * inside(wide_sigma));
  }
}

const std::vector<float>& MatchProbability::weigh(const MatchNoise& noise, const std::vector<uint8_t>& apart,
                                                  const PointColumnsView& points, float finest_weight) {
  probabilities_.assign(static_cast<size_t>(points.count), 0.f);
  for (const bool other : {false, true}) {
    if (other && apart.empty()) break;
    // The parallaxes that another motion should have are unknown.
    fit(
        points, noise, finest_weight, true,
        [&](size_t i) { return apart.empty() || apart[i] == other ? noise.residuals()[i] : kSquaredWindow; },
        [&](size_t i) { return (other ? 1.f : noise.odds()[i]) / MatchNoise::kWindow; },
        [](float sigma) { return static_cast<float>(std::sqrt(2 / M_PI)) / sigma; });
  }
  return probabilities_;
}

const std::vector<float>& MatchProbability::weighRotated(const MatchNoise& noise,
                                                         const std::vector<float>& rotation_residuals,
                                                         const PointColumnsView& points, float finest_weight) {
  probabilities_.assign(static_cast<size_t>(points.count), 0.f);
  // A transfer distance has the noise of both images.
  fit(
      points, noise, finest_weight, false, [&](size_t i) { return 0.5f * rotation_residuals[i]; },
      [](size_t) { return 1 / kSquaredWindow; }, [](float sigma) { return 0.5f / (sigma * sigma); });
  return probabilities_;
}

}  // namespace gms_ransac
