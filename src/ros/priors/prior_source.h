// Sources of priors: another sensor, tf or the ground, asked for the motion between two images. A source is a class
// that measures; its base remembers what is reported of it.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/robust_result.h"
#include "gms_ransac/triangulation.h"
#include "priors/rotation_comparison.h"
#include "priors/sensor_calibration.h"
#include "scale/ground_scale.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

/// The time between two images, seconds of the sensors' clock, and the frame of the camera that took them.
struct PriorQuery {
  std::string camera_frame;
  double from = 0, to = 0;
  double readout = 0;  ///< RobustOptions::rolling_shutter_readout: the interval around each image in which it is read
};

struct RotationAnswer {
  std::optional<RotationPrior> prior;  ///< with the rates during the readout, if that is not 0 and they are known
  std::string problem;                 ///< what is missing; empty: nothing
  PriorQuery query;
};

/// A pair as measured by the images.
struct PairSeen {
  const RobustResult& seen;
  const Triangulation& points;
  const Camera& camera;
  GroundImages images;
};

struct LengthAnswer {
  ScaleEstimate length;  ///< of the pair's translation; `features` 0: it is not known
  std::string problem;   ///< why it is not known, as the end of a sentence
};

/// For diagnostics.
struct PriorReport {
  bool doubtful = false;
  std::string summary;
  std::vector<std::pair<std::string, std::string>> values;
  std::vector<std::pair<std::string, std::string>> found;  ///< sentences on calibration, each with its key
};

/// `reaches` and `report` may be called from any thread, the rest from one.
class PriorSource {
 public:
  PriorSource() = default;
  PriorSource(const PriorSource&) = delete;
  PriorSource& operator=(const PriorSource&) = delete;
  virtual ~PriorSource() = default;
  /// Subscribes, and forgets what came before. `arrived`: called when something came that an image may wait for.
  virtual void start(const std::function<void()>& /*arrived*/) {}
  virtual void stop() {}
  /// Returns true if all that an image at the end of the query needs has come.
  virtual bool reaches(const PriorQuery& /*query*/) { return true; }
  virtual PriorReport report() = 0;
};

class RotationSource : public PriorSource {
 public:
  /// `name` and `image_time_offset`, which was added to the stamps of the images, for the report. `bias_sigma`: of
  /// the rates at rest, rad/s.
  RotationSource(std::string name, double image_time_offset, double bias_sigma = 0)
      : name_(std::move(name)), image_time_offset_(image_time_offset), calibration_(bias_sigma) {}
  bool reaches(const PriorQuery& query) override { return covers(onSensorClock(query)); }
  /// The query with the time offset that the images have shown.
  PriorQuery onSensorClock(PriorQuery query) const;
  /// Rotation of the camera between the two images. A problem is a sentence.
  RotationAnswer ask(const PriorQuery& query);
  /// Compares an answer that has a prior with the images, and learns from it; `seen` has a pose.
  void compare(const RotationAnswer& answer, const RobustResult& seen);
  /// How well source and images agree, and what explains it if they do not.
  PriorReport report() override;

 private:
  /// A problem is the end of a sentence: what is missing for the prior or, if there is one, for its rates. May be
  /// called from any thread.
  virtual RotationAnswer measure(const PriorQuery& query) = 0;
  /// As reaches(), on the sensor's clock.
  virtual bool covers(const PriorQuery& /*query*/) { return true; }

  const std::string name_;
  const double image_time_offset_;
  mutable std::mutex mutex_;  ///< guards what follows
  SensorCalibration calibration_;
  RotationComparison comparison_;
  std::string problem_;     ///< of the last answer
  double readout_ = 0;      ///< of the last query
  int pairs_by_rates_ = 0;  ///< corrected for the rolling shutter by the rates
};

class LengthSource : public PriorSource {
 public:
  /// Length of the pair's translation.
  LengthAnswer ask(const PriorQuery& query, const PairSeen& pair);
  PriorReport report() override;

 private:
  virtual LengthAnswer measure(const PriorQuery& query, const PairSeen& pair) = 0;

  std::mutex mutex_;     ///< guards what follows
  std::string problem_;  ///< of the last answer
};

/// Prior of a rotation between two poses, whose covariances are not that of the rotation: they grow with the way from
/// the start.
RotationPrior priorOfPoses(const Eigen::Matrix3d& R);

}  // namespace gms_ransac
