// ~rotation_prior tf and odom: the camera's turn between two poses of another source.
#pragma once

#include <memory>
#include <string>

#include "priors/odometry_input.h"
#include "priors/rotation_source.h"
#include "tf_lookup.h"

namespace gms_ransac {

/// The camera in a fixed frame, as tf has it at both stamps.
class TfRotation : public RotationSource {
 public:
  TfRotation(const std::string& fixed_frame, std::shared_ptr<TfLookup> tf);

  void start() override {}
  void stop() override {}
  bool reaches(const std::string& camera_frame, double stamp) override;
  std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior) override;

 private:
  const std::string fixed_frame_;
  const std::shared_ptr<TfLookup> tf_;
};

/// `prior_odom`, interpolated. Started and stopped by whoever owns the input.
class OdometryRotation : public RotationSource {
 public:
  explicit OdometryRotation(std::shared_ptr<OdometryInput> input);

  void start() override {}
  void stop() override {}
  bool reaches(const std::string& camera_frame, double stamp) override;
  std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior) override;

 private:
  const std::shared_ptr<OdometryInput> input_;
};

}  // namespace gms_ransac
