// Doubts the calibration when most pairs contradict the camera model in the same way.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <utility>

#include "gms_ransac/robust_result.h"
#include "input/camera_model.h"

namespace gms_ransac {

/// One pair may contradict a good calibration by chance, and many where objects move. A wrong calibration shows in most
/// pairs, and all of them give the same correction (doc/judgement.md).
class CalibrationWatch {
 public:
  static constexpr size_t kPairs = 60;    ///< last ones that count; no doubt before as many have come
  static constexpr double kMisfit = 1;    ///< RobustResult::camera_misfit above which a pair contradicts
  static constexpr int kDoubtAbove = 30;  ///< pairs that contradict

  /// A pair with a pose. Another camera or calibration starts anew.
  void add(const RobustResult& result, const std::shared_ptr<const CameraModel>& camera);
  /// The correction that the pairs agree on, the source of the calibration and what to check; empty: no doubt.
  std::string doubt() const;

 private:
  struct Pair {
    bool contradicts;
    CameraErrors errors;
  };
  /// Sets the mean of one error over the pairs. Returns its significance in standard deviations; 0: the pairs disagree,
  /// or the error is too small.
  double significance(size_t parameter, double& mean) const;
  /// The error and its remedy.
  std::pair<std::string, std::string> words(size_t parameter, double error) const;
  /// Height of an image in focal lengths.
  double rows() const { return camera_->camera.imageSize().height / camera_->camera.intrinsics().fy; }

  std::deque<Pair> pairs_;
  std::shared_ptr<const CameraModel> camera_;  ///< of those pairs
};

}  // namespace gms_ransac
