// The length of the translation by the ground that the camera sees, from its height above it.
#pragma once

#include <string>

#include "priors/prior_source.h"

namespace gms_ransac {

class TfLookup;

class GroundSource : public LengthSource {
 public:
  /// `camera_height`: metres. `base_frame`: level, and known to `tf`; empty, or without tf (null): the camera is level.
  GroundSource(double camera_height, const std::string& base_frame, TfLookup* tf)
      : camera_height_(camera_height), base_frame_(base_frame), tf_(tf) {}
  ScaleEstimate ask(const PriorQuery& query, const PairSeen& pair, std::string& problem) override;

 private:
  GroundPrior prior(const std::string& camera_frame) const;

  const double camera_height_;
  const std::string base_frame_;
  TfLookup* const tf_;
};

}  // namespace gms_ransac
