// Whether a match is right, by a truth that has noise of its own.
#pragma once

#include <optional>

#include "gms_ransac/camera.h"
#include "run/pair_truth.h"
#include "trust/truth_noise.h"

namespace gms_ransac {

/// Labels the matches of one pair of images: within kCorrectWithin of their true place (homography, disparity, depth)
/// or, where that is not known, of their epipolar line; widened by what two standard deviations of the true pose move
/// it. No label where that exceeds kLoosestLabel, and for epipolar lines of a camera that hardly moved.
class MatchLabel {
 public:
  MatchLabel(const PairTruth& truth, const Camera& camera, const TruthNoise& noise, const ClockStep& step = {});
  std::optional<bool> operator()(const cv::Point2f& reference, const cv::Point2f& current) const;

 private:
  std::optional<bool> within(double distance, double pose_noise_px) const;
  /// Of the match against the true rotation alone, pixels: what the translation moved.
  double parallax(const cv::Point2f& reference, const cv::Point2f& current) const;

  const PairTruth& truth_;
  const Camera& camera_;
  bool moved_ = false;
  double baseline_ = 0;                                ///< metres
  double rotation_sigma_ = 0, translation_sigma_ = 0;  ///< of the truth, along its worst axis; radians, metres
};
constexpr double kLoosestLabel = 10;  ///< pixels

}  // namespace gms_ransac
