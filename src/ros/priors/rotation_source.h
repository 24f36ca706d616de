// Sources of a rotation prior: one interface, a class for each word of ~rotation_prior. imu_rotation.h has the
// gyroscope.
#pragma once

#include <memory>
#include <string>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

class OdometryInput;
class TfLookup;

/// Times are seconds of the sensor's clock: image stamps plus ~image_time_offset. May be called from any thread, but
/// start and stop.
class RotationSource {
 public:
  virtual ~RotationSource() = default;

  /// Subscribes, and forgets what came before.
  virtual void start() {}
  virtual void stop() {}
  /// Everything up to this time has arrived.
  virtual bool reaches(const std::string& camera_frame, double stamp) = 0;
  /// Rotation of the camera between two times. Returns an empty string, or why it is unknown, as the end of a sentence.
  virtual std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior) = 0;
  /// True if the source resolves the time between the rows of one image.
  virtual bool tellsRates() const { return false; }
  /// Gives the rotation that the images show to a source that learns from it.
  virtual void learn(const std::string& /*camera_frame*/, double /*from*/, double /*to*/,
                     const RotationPrior& /*visual*/) {}
  /// Summary of what was learnt, for diagnostics; empty: nothing.
  virtual std::string learnt() { return std::string(); }
};

/// The camera in a fixed frame, as tf has it at both stamps.
class TfRotation : public RotationSource {
 public:
  TfRotation(const std::string& fixed_frame, std::shared_ptr<TfLookup> tf);

  bool reaches(const std::string& camera_frame, double stamp) override;
  std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior) override;

 private:
  const std::string fixed_frame_;
  const std::shared_ptr<TfLookup> tf_;
};

/// Interpolates `prior_odom`. The owner of the input starts and stops it.
class OdometryRotation : public RotationSource {
 public:
  explicit OdometryRotation(std::shared_ptr<OdometryInput> input);

  bool reaches(const std::string& camera_frame, double stamp) override;
  std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior) override;

 private:
  const std::shared_ptr<OdometryInput> input_;
};

}  // namespace gms_ransac
