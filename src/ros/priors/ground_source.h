// The length of the translation by the ground that the camera sees, from its height above it.
#pragma once

#include <string>

#include "parameters.h"
#include "priors/prior_source.h"

namespace gms_ransac {

class TfLookup;

class GroundSource : public LengthSource {
 public:
  GroundSource(const Parameters& parameters, TfLookup* tf)
      : camera_height_(parameters.camera_height), base_frame_(parameters.base_frame), tf_(tf) {}

 private:
  LengthAnswer measure(const PriorQuery& query, const PairSeen& pair) override;
  GroundPrior prior(const std::string& camera_frame) const;

  const double camera_height_;    ///< metres
  const std::string base_frame_;  ///< level, and known to tf; empty, or without tf: the camera is level
  TfLookup* const tf_;            ///< null: none
};

}  // namespace gms_ransac
