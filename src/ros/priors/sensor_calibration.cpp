#include "priors/sensor_calibration.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <opencv2/core.hpp>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Constants = Eigen::Matrix<double, 7, 1>;

// Before anything is learnt, radians and seconds: for the rotations of a sensor that is mounted and stamped with care,
// and for what may be found.
constexpr double kUsualMount = 0.01, kUsualOffset = 0.002, kFirstMount = 0.05, kFirstOffset = 0.05;
// Drift over a second: of a mounting that bends, radians, of a clock, seconds, and of a MEMS gyro's bias, rad/s.
constexpr double kMountDrift = 1e-5, kOffsetDrift = 1e-5, kBiasDrift = 1e-4;
/// Least standard deviation of a visual rotation, radians: what is common to pairs, as the lens, is in no covariance.
constexpr double kVisualFloor = 2e-4;
/// Errors of a pair: jitter of stamps, seconds, and a share of the rotation, as focal length and gyro have another
/// scale.
constexpr double kJitter = 0.002, kShare = 0.005;
constexpr double kLeastStep = 0.001;  ///< of the derivative by the time offset, seconds
constexpr size_t kMostWaiting = 30;   ///< pairs, a second of images
constexpr double kSignificant = 4;    ///< standard deviations
constexpr double kDegrees = 180 / CV_PI;

Constants constants(double mount, double offset, double bias) {
  Constants all;
  all << mount, mount, mount, offset, bias, bias, bias;
  return all;
}

std::string triple(const Vector3d& v, const char* format) {
  const auto text = [&](int k) { return cv::format(format, v[k]); };
  return "(" + text(0) + ", " + text(1) + ", " + text(2) + ")";
}

}  // namespace

SensorCalibration::SensorCalibration(double bias_sigma)
    : has_bias_(bias_sigma > 0),
      usual_(constants(kUsualMount, kUsualOffset, std::max(bias_sigma, 1e-6))),
      constants_(constants(kFirstMount, kFirstOffset, usual_[kBias]),
                 constants(kMountDrift, kOffsetDrift, has_bias_ ? kBiasDrift : 0)),
      before_last_(constants_),
      known_(constants_.known(usual_)) {}

SensorCalibration::Predicted SensorCalibration::predict(const Constants::Vector& constants, const Vector3d& measured,
                                                        const Vector3d& by_offset, double seconds) {
  const Matrix3d mounting = rotationFromVector(constants.segment<3>(kMounting));
  Predicted predicted;
  predicted.rotation = mounting * (measured - seconds * constants.segment<3>(kBias));
  predicted.derivative << -crossMatrix(predicted.rotation), mounting * by_offset, -seconds * mounting;
  const Vector3d jitter = kJitter * predicted.derivative.col(kTimeOffset), share = kShare * predicted.rotation;
  predicted.errors = jitter * jitter.transpose() + share * share.transpose();
  return predicted;
}

void SensorCalibration::add(const SeenRotation& pair, const RotationBetween& sensor) {
  if (!pair.rotation.allFinite() || !pair.covariance.allFinite() || !(pair.from < pair.to)) return;
  if (!waiting_.empty() && pair.from < waiting_.back().from) waiting_.clear();
  waiting_.push_back(pair);
  while (!waiting_.empty() && (learn(waiting_.front(), sensor) || waiting_.size() > kMostWaiting)) waiting_.pop_front();
}

bool SensorCalibration::learn(const SeenRotation& pair, const RotationBetween& sensor) {
  // Central differences over a standard deviation of the offset (Norgaard et al. 2000).
  const Constants::Estimate& learnt = (pair.from == last_.from ? before_last_ : constants_).learnt();
  const double step = std::max(kLeastStep, learnt.deviation()[kTimeOffset]);
  const double from = pair.from + learnt.mean[kTimeOffset], to = pair.to + learnt.mean[kTimeOffset];
  const auto middle = sensor(from, to), earlier = sensor(from - step, to - step),
             later = sensor(from + step, to + step);
  if (!middle || !earlier || !later) return false;
  const Vector3d measured = rotationVector(middle->R), before = rotationVector(earlier->R),
                 after = rotationVector(later->R), bend = after - 2 * measured + before;
  const Predicted predicted =
      predict(learnt.mean, measured + 0.5 * bend, (after - before) / (2 * step), pair.to - pair.from);
  const Matrix3d noise = pair.covariance + middle->covariance + predicted.errors + 0.5 * bend * bend.transpose() +
                         kVisualFloor * kVisualFloor * Matrix3d::Identity();
  const Vector3d residual = pair.rotation - predicted.rotation;
  const Eigen::Matrix<double, 7, 3> weighted = predicted.derivative.transpose() * noise.inverse();
  if (pair.from == last_.from) constants_ = before_last_;
  before_last_ = constants_;
  constants_.add({weighted * residual, weighted * predicted.derivative, residual.dot(noise.inverse() * residual), 3},
                 last_.to > 0 ? pair.to - last_.to : 0);
  known_ = constants_.known(usual_);
  last_ = pair;
  return true;
}

std::optional<RotationPrior> SensorCalibration::correct(const RotationBetween& sensor, double from, double to) const {
  const double step = std::max(kLeastStep, known_.deviation()[kTimeOffset]), late = timeOffset();
  std::optional<RotationPrior> prior = sensor(from + late, to + late);
  if (!prior) return prior;
  const Vector3d measured = rotationVector(prior->R);
  const auto earlier = sensor(from + late - step, to + late - step);
  const Vector3d by_offset = earlier ? Vector3d((measured - rotationVector(earlier->R)) / step) : Vector3d::Zero();
  const Predicted predicted = predict(known_.mean, measured, by_offset, to - from);
  prior->R = rotationFromVector(predicted.rotation);
  prior->covariance += predicted.errors + predicted.derivative * known_.covariance * predicted.derivative.transpose();
  if (prior->rates) {
    for (Vector3d* rate : {&prior->rates->reference, &prior->rates->current}) {
      *rate = predict(known_.mean, *rate, Vector3d::Zero(), 1).rotation;
    }
  }
  return prior;
}

std::vector<std::pair<std::string, std::string>> SensorCalibration::found(const std::string& sensor,
                                                                          double image_time_offset) const {
  const Vector3d mounting = known_.mean.segment<3>(kMounting), spread = known_.deviation().segment<3>(kMounting);
  const double late = timeOffset(), sigma = known_.deviation()[kTimeOffset];
  const std::string key = sensor + std::to_string(constants_.restarts());
  std::vector<std::pair<std::string, std::string>> sentences;
  if (std::abs(late) > std::max(kUsualOffset, kSignificant * sigma)) {
    sentences.emplace_back(
        "stamps of " + key,
        cv::format("the stamps of %s are %.4f s %s (standard deviation %.4f s), which is corrected; "
                   "correct its driver, or set ~image_time_offset to %.4f",
                   sensor.c_str(), std::abs(late), late > 0 ? "late" : "early", sigma, image_time_offset + late));
  }
  if ((mounting.array().abs() > (kSignificant * spread).array().max(kUsualMount)).any()) {
    sentences.emplace_back("mounting of " + key,
                           sensor +
                               " is mounted otherwise than tf says, which is corrected; rotate the camera in tf by " +
                               triple(-kDegrees * mounting, "%.2f") + " degrees (standard deviations " +
                               triple(kDegrees * spread, "%.2f") + ") about its x, y and z");
  }
  return sentences;
}

std::vector<std::pair<std::string, std::string>> SensorCalibration::values(double image_time_offset) const {
  const Constants::Vector deviation = known_.deviation();
  const auto withSpread = [&](int from, double unit, const char* format) {
    return triple(unit * known_.mean.segment<3>(from), format) + ", standard deviations " +
           triple(unit * deviation.segment<3>(from), format);
  };
  std::vector<std::pair<std::string, std::string>> values = {
      {"~image_time_offset (s)",
       cv::format("%.4f, standard deviation %.4f", image_time_offset + timeOffset(), deviation[kTimeOffset])},
      {"mounting (degrees)", withSpread(kMounting, kDegrees, "%.2f")}};
  if (has_bias_) values.emplace_back("bias about the camera's axes (rad/s)", withSpread(kBias, 1, "%.4f"));
  return values;
}

}  // namespace gms_ransac
