// Rates of a gyro, poses and twists of wheels, and the rotations that images show, in any order and of any size. Each
// motion between two stamps is finite and its rotation is one, or a sentence names the sample that is missing.
#include <optional>

#include <Eigen/LU>

#include "fuzz_input.h"
#include "priors/motion_track.h"
#include "priors/rotation_comparison.h"
#include "priors/sensor_calibration.h"
#include "priors/wheel_check.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

using Eigen::Vector3d;

Vector3d fuzzedVector(FuzzInput& input, double most) {
  const double x = input.number(-most, most), y = input.number(-most, most), z = input.number(-most, most);
  return {x, y, z};
}

/// The next stamp, seconds: mostly a little later.
double nextStamp(FuzzInput& input, double stamp) {
  const uint8_t kind = input.byte();
  const double next = kind < 224 ? stamp + input.within(0, 0.1) : stamp + input.number(-100, 100);
  return next > 0 && next < 4.3e9 ? next : 1000;
}

template <typename Track>
void checkTrack(const Track& track, double from, double to) {
  demand(track.samples() <= Track::kMostSamples, "the samples are bounded");
  TrackMotion motion;
  const std::string problem = track.between(from, to, motion);
  demand(problem.size() < 1000, "a sentence is short");
  if (!problem.empty()) return;
  const Eigen::Matrix3d R = motion.motion.linear();
  demand(std::isfinite(motion.variance) && motion.variance >= 0, "a variance is one");
  demand((R.transpose() * R).isIdentity(1e-6) && R.determinant() > 0, "a motion's rotation is one");
}

void checkTracks(FuzzInput& input) {
  GyroTrack gyro;
  OdometryTrack wheels;
  SensorCalibration calibration(0.05);
  RotationComparison comparison;
  double stamp = 1000;
  const auto prior = [&gyro](double from, double to) -> std::optional<RotationPrior> {
    TrackMotion motion;
    if (!gyro.between(from, to, motion).empty()) return std::nullopt;
    return RotationPrior{motion.motion.linear(), motion.variance * Eigen::Matrix3d::Identity(), {}};
  };
  for (int i = 0; i < 200 && !input.empty(); ++i) {
    const double before = stamp;
    stamp = nextStamp(input, stamp);
    const int kind = input.between(0, 7);
    if (kind < 4) {
      gyro.add(stamp, fuzzedVector(input, 3), input.byte() > 200 ? input.number(0, 1) : 0);
    } else if (kind < 6) {
      OdometrySample sample;
      sample.stamp = stamp;
      sample.pose.translation() = fuzzedVector(input, 10);
      if (input.flag()) sample.pose.linear() = rotationFromVector(Vector3d(0, 0, input.within(-3, 3)));
      sample.velocity = fuzzedVector(input, 2);
      sample.angular = fuzzedVector(input, 1);
      sample.velocity_variance = std::max(0.0, input.number(0, 1));
      wheels.add(sample);
    } else if (const auto rotation = prior(before - 0.2, before)) {
      const Vector3d measured = rotationVector(rotation->R);
      const ComparedRotation pair = {before - 0.2, before, measured + 0.01 * fuzzedVector(input, 1), measured,
                                     1e-6 * (1 + input.byte()) * Eigen::Matrix3d::Identity()};
      calibration.add({pair.from, pair.to, pair.visual, pair.covariance}, prior);
      comparison.add(pair);
      const auto corrected = calibration.correct(prior, pair.from, pair.to);
      demand(!corrected || (corrected->R.allFinite() && corrected->covariance.allFinite()), "a prior is finite");
    }
    checkTrack(gyro, stamp - input.within(0, 2), stamp);
    checkTrack(wheels, stamp - input.within(0, 2), stamp);
  }
  demand(std::isfinite(calibration.timeOffset()), "an offset is finite");
  demand(comparison.doubt().size() < 1000, "a doubt is short");
}

void checkWheels(FuzzInput& input) {
  WheelCheck check;
  for (int i = 0; i < 100 && !input.empty(); ++i) {
    RobustResult seen;
    seen.judgement.translation_observable = input.flag();
    seen.judgement.median_parallax_px = std::abs(input.within(0, 50));
    seen.judgement.sigma_px = input.within(0.05, 2);
    seen.judgement.pose.t = Vector3d(input.within(-1, 1), input.within(-1, 1), input.within(0.1, 1)).normalized();
    const Vector3d travelled = fuzzedVector(input, 3);
    if (travelled.allFinite()) demand(check.judge(travelled, seen).size() < 1000, "a doubt is short");
  }
}

}  // namespace

void check(FuzzInput input) {
  if (input.flag()) return checkWheels(input);
  checkTracks(input);
}

}  // namespace gms_ransac
