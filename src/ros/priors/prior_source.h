// Interface of the sources of priors: another sensor, tf or the ground, asked for the motion between two images.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/robust_result.h"
#include "gms_ransac/triangulation.h"
#include "scale/ground_scale.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

/// The time between two images, seconds of the sensors' clock, and the frame of the camera that took them.
struct PriorQuery {
  std::string camera_frame;
  double from = 0, to = 0;
};

/// A pair as measured by the images.
struct PairSeen {
  const RobustResult& seen;
  const Triangulation& points;
  const Camera& camera;
  GroundImages images;
};

/// For diagnostics.
struct PriorReport {
  bool doubtful = false;
  std::string summary;
  std::vector<std::pair<std::string, std::string>> values;
};

/// `reaches` and `report` may be called from any thread, the rest from one.
class PriorSource {
 public:
  PriorSource() = default;
  PriorSource(const PriorSource&) = delete;
  PriorSource& operator=(const PriorSource&) = delete;
  virtual ~PriorSource() = default;
  /// Subscribes, and forgets what came before. `arrived`: called when something came that an image may wait for.
  virtual void start(const std::function<void()>& arrived);
  virtual void stop();
  /// Returns true if all that an image of this stamp needs has come.
  virtual bool reaches(const std::string& camera_frame, double stamp);
  /// Adds what it has learnt.
  virtual void report(PriorReport& report);
};

class RotationSource : public PriorSource {
 public:
  /// Rotation of the camera. Returns an empty string, or what is missing, as the end of a sentence. May be called from
  /// any thread.
  virtual std::string ask(const PriorQuery& query, RotationPrior& prior) = 0;
  /// Adds the rotation rates during the readout of the two images. Returns what is missing.
  virtual std::string askRates(const PriorQuery& query, RotationPrior& prior);
  /// Learns from the rotation that the images show.
  virtual void compare(const PriorQuery& query, const RotationPrior& visual);
};

class LengthSource : public PriorSource {
 public:
  /// Length of the pair's translation. `features` 0: it is not known, and `problem` says why.
  virtual ScaleEstimate ask(const PriorQuery& query, const PairSeen& pair, std::string& problem) = 0;
};

inline void PriorSource::start(const std::function<void()>& /*arrived*/) {}
inline void PriorSource::stop() {}
inline bool PriorSource::reaches(const std::string& /*camera_frame*/, double /*stamp*/) { return true; }
inline void PriorSource::report(PriorReport& /*report*/) {}
inline std::string RotationSource::askRates(const PriorQuery& /*query*/, RotationPrior& /*prior*/) { return {}; }
inline void RotationSource::compare(const PriorQuery& /*query*/, const RotationPrior& /*visual*/) {}

/// Prior of a rotation between two poses, whose covariances are not that of the rotation: they grow with the way from
/// the start.
RotationPrior priorOfPoses(const Eigen::Matrix3d& R);

}  // namespace gms_ransac
