// Checks the length measured by wheels against the parallax in the images: finds slip. Knows no topic.
#pragma once

#include <deque>
#include <string>

#include <Eigen/Core>

#include "gms_ransac/robust_result.h"

namespace gms_ransac {

class WheelCheck {
 public:
  static constexpr double kStanding = 0.002;  ///< metres between two images that are none: a tick of most encoders
  static constexpr double kSlip = 4;          ///< factor by which parallax over length may differ from its usual value
  static constexpr size_t kPairs = 30, kFewest = 10;  ///< from which the usual ratio is taken
  static constexpr double kOtherWay = 0.5;            ///< cosine: more than 60 degrees off

  /// `travelled`: the camera's translation by the odometry, metres, in the reference camera's frame. Returns why its
  /// length is not to be used, as the end of a sentence; empty: it is. Remembers the parallax, which is compared with
  /// that of later pairs.
  std::string judge(const Eigen::Vector3d& travelled, const RobustResult& seen);

 private:
  std::deque<double> usual_;  ///< pixels of parallax for a metre
};

}  // namespace gms_ransac
