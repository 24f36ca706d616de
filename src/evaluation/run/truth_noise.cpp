#include "run/truth_noise.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr double kMovedDeviations = 10;  // of the truth's noise
constexpr double kRounding = 1e-6;       // metres, of exact poses that were written as text
constexpr double kDegree = M_PI / 180;

/// A 30 Hz camera without a trigger: its stamp is uniform between two frames. Seconds.
const double kFrameClock = 1 / 30. / std::sqrt(12.);

struct KindOfTruth {
  const char* word;  ///< in the set's name, in small letters
  TruthNoise noise;
};
const KindOfTruth kKinds[] = {
    {"rendered", {0, 0, 0, 0}},
    {"kitti", {0.01 * kDegree, 0.005, 0, 0.1 * kDegree}},
    {"euroc", {0.05 * kDegree, 0.001, 0, 0}},
    {"7scenes", {0.2 * kDegree, 0.01, kFrameClock, 0}},
    {"tum", {0.2 * kDegree, 0.001, kFrameClock, 0}},
    {"freiburg", {0.2 * kDegree, 0.001, kFrameClock, 0}},
};

/// The true motion of a pair whose images were taken `later` seconds after their stamps.
std::optional<Isometry3d> motion(const Dataset& dataset, const DatasetPair& pair, double later) {
  const auto poseOf = [&](int frame) -> std::optional<Isometry3d> {
    const std::optional<double> stamp = dataset.stamp(frame);
    return stamp ? dataset.truthAt(*stamp + later) : std::nullopt;
  };
  const auto reference = poseOf(pair.reference), current = poseOf(pair.current);
  if (!reference || !current) return std::nullopt;
  return reference->inverse() * *current;
}

/// Covariance of a vector in axes that are rotated by `sigma` about each.
Matrix3d byRotation(double sigma, const Vector3d& v) {
  return sigma * sigma * (v.squaredNorm() * Matrix3d::Identity() - v * v.transpose());
}

}  // namespace

TruthNoise defaultTruthNoise(const std::string& path) {
  std::string name = setName(path);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const KindOfTruth& kind : kKinds) {
    if (name.find(kind.word) != std::string::npos) return kind.noise;
  }
  return defaultTruthNoise(fs::exists(fs::path(kittiRigOf(path).value_or(path)) / "poses.txt") ? "kitti" : "tum");
}

ClockStep clockStep(const Dataset& dataset, const DatasetPair& pair, double clock) {
  ClockStep step;
  if (clock == 0) return step;
  const auto sooner = motion(dataset, pair, -clock), later = motion(dataset, pair, clock);
  if (!sooner || !later) return step;
  step.rotation = 0.5 * rotationVector(later->linear() * sooner->linear().transpose());
  step.translation = 0.5 * (later->translation() - sooner->translation());
  return step;
}

PairNoise::PairNoise(const TruthNoise& noise, const ClockStep& step, const Isometry3d& truth)
    : rotation(noise.rotation * noise.rotation * Matrix3d::Identity()),
      translation(noise.translation * noise.translation * Matrix3d::Identity()) {
  rotation += step.rotation * step.rotation.transpose();
  translation += step.translation * step.translation.transpose();
  rotation += byRotation(noise.alignment, rotationVector(truth.linear()));
  translation += byRotation(noise.alignment, truth.translation());
}

bool hasMoved(double baseline, const TruthNoise& noise) {
  return baseline > kRounding && baseline >= kMovedDeviations * noise.translation;
}

}  // namespace gms_ransac
