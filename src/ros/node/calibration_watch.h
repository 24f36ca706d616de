// Whether the pairs contradict the camera model so often, and so alike, that the calibration cannot be right.
#pragma once

#include <deque>
#include <string>

#include "gms_ransac/camera.h"
#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

/// One pair may contradict a good calibration by chance, and many where something moves by itself. What is wrong with
/// the calibration shows in most pairs, and all of them ask for the same correction (doc/uncertainty.md).
class CalibrationWatch {
 public:
  static constexpr size_t kPairs = 60;    ///< last ones that count; no doubt before as many have come
  static constexpr double kMisfit = 1;    ///< RobustResult::camera_misfit above which a pair contradicts
  static constexpr int kDoubtAbove = 30;  ///< pairs that contradict

  /// A pair with a pose, by this camera.
  void add(const RobustResult& result, const Camera& camera);
  /// Another camera, or another calibration: what was seen before does not count.
  void reset();
  /// One sentence that names what to look at, and by how much it seems to be wrong; empty: no doubt.
  std::string doubt() const;

 private:
  struct Pair {
    bool contradicts = false;
    CameraErrors errors;
  };
  /// What the pairs say together of one error.
  struct Consensus {
    double mean = 0;
    double significance = 0;  ///< of the mean, in standard deviations by which the pairs differ
    double agreeing = 0;      ///< share of the pairs that have its sign
  };

  Consensus consensus(CameraErrors::Parameter parameter) const;
  /// How significant an error is that all pairs agree on and that matters; 0 else.
  double weigh(CameraErrors::Parameter parameter, const Consensus& consensus) const;
  std::string describe(CameraErrors::Parameter parameter, double error) const;

  std::deque<Pair> pairs_;
  int contradictions_ = 0;       ///< among them
  Eigen::Vector2d focal_{1, 1};  ///< of the camera, pixels
  double rows_ = 1;              ///< of its image, focal lengths
};

}  // namespace gms_ransac
