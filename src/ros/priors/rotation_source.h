// Where a rotation prior comes from: one interface, a class for each of ~rotation_prior's words.
#pragma once

#include <string>

#include "gms_ransac/rotation_prior.h"

namespace gms_ransac {

/// Times are seconds of the sensor's clock: image stamps plus ~image_time_offset. May be called from any thread, but
/// start and stop.
class RotationSource {
 public:
  virtual ~RotationSource() = default;

  /// Subscribes, and forgets what came before.
  virtual void start() = 0;
  virtual void stop() = 0;
  /// What comes later changes nothing at this time.
  virtual bool reaches(const std::string& camera_frame, double stamp) = 0;
  /// The camera's turn between two times. Returns an empty string, or why there is none, as the end of a sentence.
  virtual std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior) = 0;
  /// Whether turns between times as near as the rows of one image are told, too.
  virtual bool tellsRates() const { return false; }
  /// What the images made of it, for a source that learns from them.
  virtual void learn(const std::string& /*camera_frame*/, double /*from*/, double /*to*/,
                     const RotationPrior& /*visual*/) {}
  /// What it learnt, in words for diagnostics; empty: nothing.
  virtual std::string learnt() { return std::string(); }
};

}  // namespace gms_ransac
