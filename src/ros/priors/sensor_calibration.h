// Time offset, mounting and bias of a sensor that measures rotations, learnt from the rotations that images show. Knows
// no topic.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/relative_pose.h"
#include "priors/drifting_constants.h"

namespace gms_ransac {

/// A pair as measured by the images.
struct SeenRotation {
  double from = 0, to = 0;                               ///< seconds, stamps of the images
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();    ///< vector of X_reference = R X_current
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of it
};

class SensorCalibration {
 public:
  /// Rotation of the camera between two times of the sensor's clock, as it is mounted by tf; none where the sensor
  /// does not know.
  using RotationBetween = std::function<std::optional<RotationPrior>(double from, double to)>;

  /// `bias_sigma`: of the rates that the sensor shows at rest, rad/s.
  explicit SensorCalibration(double bias_sigma);

  /// Learns from a pair, as soon as the sensor knows more than it. One with the start of the pair before replaces it,
  /// as while the reference is held.
  void add(const SeenRotation& pair, const RotationBetween& sensor);

  /// Factor on the covariances of pairs that their residuals ask for.
  double dispersion() const { return constants_.dispersion(); }
  /// Seconds by which the stamps of the sensor are late, as far as known.
  double timeOffset() const { return known_.mean[kTimeOffset]; }
  /// The sensor's rotation between two stamps of images, corrected, with the covariance of the correction.
  std::optional<RotationPrior> correct(const RotationBetween& sensor, double from, double to) const;

  /// Sentences for a calibration: where offset and mounting are known not to be as stamps and tf say. Each with a key
  /// that changes if the numbers do. `image_time_offset`: what the stamps of the images have been corrected by.
  std::vector<std::pair<std::string, std::string>> found(const std::string& sensor, double image_time_offset) const;
  /// The numbers and their deviations, by name.
  std::vector<std::pair<std::string, std::string>> values(double image_time_offset) const;

 private:
  static constexpr int kMounting = 0, kTimeOffset = 3, kBias = 4;
  using Constants = DriftingConstants<7>;  ///< rotation vector, radians; seconds; rad/s, axes of the camera by tf
  /// A rotation, its derivative by the constants, and the covariance of what differs from pair to pair.
  struct Predicted {
    Eigen::Vector3d rotation;
    Eigen::Matrix<double, 3, 7> derivative;
    Eigen::Matrix3d errors;
  };
  static Predicted predict(const Constants::Vector& constants, const Eigen::Vector3d& measured,
                           const Eigen::Vector3d& by_offset, double seconds);
  /// Returns false if the sensor does not know the pair, yet or any more.
  bool learn(const SeenRotation& pair, const RotationBetween& sensor);

  const bool has_bias_;
  const Constants::Vector usual_;  ///< deviations of a careful installation
  Constants constants_, before_last_;
  Constants::Estimate known_;
  std::deque<SeenRotation> waiting_;
  SeenRotation last_;
};

}  // namespace gms_ransac
