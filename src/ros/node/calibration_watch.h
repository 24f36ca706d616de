// Whether the pairs contradict the camera model so often that the calibration cannot be right.
#pragma once

#include <array>
#include <deque>
#include <string>

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

/// One pair may contradict a good calibration, by chance or because something moved. What is wrong with the calibration
/// shows in most pairs, and always in the same way.
class CalibrationWatch {
 public:
  static constexpr int kPairs = 30;       ///< last ones that count; no doubt before as many have come
  static constexpr double kMisfit = 1;    ///< RobustResult::camera_misfit above which a pair contradicts
  static constexpr int kDoubtAbove = 15;  ///< pairs that contradict in one parameter

  /// A pair with a pose.
  void add(const RobustResult& result);
  /// Another camera, or another calibration: what was seen before does not count.
  void reset();
  /// One sentence that names the parameter to look at, and what else looks like it; empty: no doubt.
  std::string doubt() const;

 private:
  static constexpr int kNone = -1;

  std::deque<int> contradicted_;         ///< parameter of each of the last pairs, or kNone
  std::array<int, 4> contradictions_{};  ///< among them, by parameter
};

}  // namespace gms_ransac
