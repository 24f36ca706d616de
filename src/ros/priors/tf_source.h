// The rotation of the camera in a fixed frame, as tf has it.
#pragma once

#include <string>

#include "priors/prior_source.h"

namespace gms_ransac {

class TfLookup;

class TfSource : public RotationSource {
 public:
  TfSource(const std::string& fixed_frame, TfLookup& tf) : fixed_frame_(fixed_frame), tf_(tf) {}
  bool reaches(const std::string& camera_frame, double stamp) override;
  std::string ask(const PriorQuery& query, RotationPrior& prior) override;

 private:
  const std::string fixed_frame_;
  TfLookup& tf_;
};

}  // namespace gms_ransac
