// The rotation of the camera in a fixed frame, as tf has it.
#pragma once

#include <string>

#include "parameters.h"
#include "priors/prior_source.h"

namespace gms_ransac {

class TfLookup;

class TfSource : public RotationSource {
 public:
  TfSource(const Parameters& parameters, TfLookup& tf)
      : RotationSource("tf", parameters.image_time_offset), fixed_frame_(parameters.prior_frame), tf_(tf) {}

 private:
  RotationAnswer measure(const PriorQuery& query) override;
  bool covers(const PriorQuery& query) override;

  const std::string fixed_frame_;
  TfLookup& tf_;
};

}  // namespace gms_ransac
