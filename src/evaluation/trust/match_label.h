// Whether a match is right, by a truth that has noise of its own.
#pragma once

#include <optional>

#include "gms_ransac/camera.h"
#include "run/pair_truth.h"

namespace gms_ransac {

/// How far the true relative pose of a pair is from the motion that the images saw: standard deviations for each axis.
struct TruthNoise {
  double rotation = 0;     ///< radians
  double translation = 0;  ///< metres
};

/// Labels the matches of one pair of images: within kCorrectWithin of their true place (homography, disparity, depth)
/// or, where that is not known, of their epipolar line; widened by what two standard deviations of the true pose move
/// it. No label where that exceeds kLoosestLabel, and for epipolar lines of a camera that hardly moved.
class MatchLabel {
 public:
  MatchLabel(const PairTruth& truth, const Camera& camera, const TruthNoise& noise);
  std::optional<bool> operator()(const cv::Point2f& reference, const cv::Point2f& current) const;

 private:
  std::optional<bool> within(double distance, double pose_noise_px) const;
  /// Of the match against the true rotation alone, pixels: what the translation moved.
  double parallax(const cv::Point2f& reference, const cv::Point2f& current) const;

  const PairTruth& truth_;
  const Camera& camera_;
  TruthNoise noise_;
  double baseline_ = 0;  ///< metres
};
constexpr double kLoosestLabel = 10;  ///< pixels

/// Whether the camera moved by so much that the true direction means something: ten of the truth's deviations, which
/// leaves the direction six degrees.
bool hasMoved(double baseline, const TruthNoise& noise);

}  // namespace gms_ransac
