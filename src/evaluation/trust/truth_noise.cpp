#include "trust/truth_noise.h"

#include <cmath>
#include <optional>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

constexpr double kMovedDeviations = 10;  // of the truth's noise, for a direction to mean something
constexpr double kRounding = 1e-6;       // metres, of exact poses that were written as text

/// The true motion of a pair whose images were taken `later` seconds than their stamps say.
std::optional<Eigen::Isometry3d> motion(const Dataset& dataset, const DatasetPair& pair, double later) {
  const auto poseOf = [&](int frame) -> std::optional<Eigen::Isometry3d> {
    const std::optional<double> stamp = dataset.stamp(frame);
    if (!stamp) return std::nullopt;
    return dataset.truthAt(*stamp + later);
  };
  const auto reference = poseOf(pair.reference), current = poseOf(pair.current);
  if (!reference || !current) return std::nullopt;
  return reference->inverse() * *current;
}

/// Covariance of what a turn of the axes by `sigma` about each does to a vector.
Eigen::Matrix3d byTurn(double sigma, const Eigen::Vector3d& v) {
  return sigma * sigma * (v.squaredNorm() * Eigen::Matrix3d::Identity() - v * v.transpose());
}

}  // namespace

ClockStep clockStep(const Dataset& dataset, const DatasetPair& pair, double clock) {
  ClockStep step;
  if (clock == 0) return step;
  const auto sooner = motion(dataset, pair, -clock), later = motion(dataset, pair, clock);
  if (!sooner || !later) return step;
  step.rotation = 0.5 * rotationVector(later->linear() * sooner->linear().transpose());
  step.translation = 0.5 * (later->translation() - sooner->translation());
  return step;
}

PairNoise::PairNoise(const TruthNoise& noise, const ClockStep& step, const Eigen::Isometry3d& truth)
    : rotation(noise.rotation * noise.rotation * Eigen::Matrix3d::Identity()),
      translation(noise.translation * noise.translation * Eigen::Matrix3d::Identity()) {
  rotation += step.rotation * step.rotation.transpose();
  translation += step.translation * step.translation.transpose();
  rotation += byTurn(noise.alignment, rotationVector(truth.linear()));
  translation += byTurn(noise.alignment, truth.translation());
}

bool hasMoved(double baseline, const TruthNoise& noise) {
  return baseline > kRounding && baseline >= kMovedDeviations * noise.translation;
}

}  // namespace gms_ransac
