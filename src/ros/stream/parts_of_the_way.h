// Odometries that begin anew with earlier images, as ~set_pose begins them: the motion over parts of the way, with the
// covariance that ~odom has of it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "parameters.h"
#include "stream/odometry.h"
#include "stream/processed_frame.h"
#include "stream/stream_odometry.h"

namespace gms_ransac {

/// A place as ~odom and ~twist publish it of the camera, with this answer.
OdometryEstimate publishedOf(const Parameters& parameters, const MotionIntegrator& place, const ProcessedFrame& answer);

class PartsOfTheWay {
 public:
  /// The parts that end with this answer.
  std::vector<OdometryPart> add(const Parameters& parameters, const ProcessedFrame& answer);

 private:
  static constexpr std::array<double, 3> kLengths = {1, 10, 50};  ///< metres, and seconds
  struct Beginning {
    double stamp, way;
    MotionIntegrator place;
    size_t metres = 0, seconds = 0;  ///< of kLengths: those that have ended
  };
  void moveOn(const Parameters& parameters, const ProcessedFrame& answer);
  void begin(const ProcessedFrame& answer);

  std::vector<Beginning> begun_;
  double way_ = 0;  ///< of the place
  std::optional<Eigen::Vector3d> position_;
};

}  // namespace gms_ransac
