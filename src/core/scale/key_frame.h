// The motion in metres since an earlier image, the key frame.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/relative_pose.h"
#include "scale/joint_refinement.h"
#include "scale/pair_points.h"

namespace gms_ransac {

/// An earlier image whose points are still followed. The motion since it is that of the pairs chained, and what its
/// points tell by themselves; so the noise of the pairs between does not add up.
struct KeyFrame {
  struct Point {
    uint32_t track;
    SeenPoint seen;
    cv::Point pixel;        ///< that `seen` is of
    Eigen::Matrix2f shape;  ///< of the patch there, in the last image that showed it (PatchPlace)
  };
  std::vector<Point> points;             ///< in the order of their tracks
  cv::Mat image;                         ///< CV_8UC1, of its own memory; empty: no pixels
  RelativePose reference, current;       ///< of these cameras in that of the key frame, metres
  bool is_reference = true;              ///< it became the key frame with this pair
  std::optional<SensorEvidence> sensor;  ///< by `current`

  /// Sets `current` by the motion of a pair and by the points that are still followed, with the pair's prior of the
  /// sensor. If these are few, the reference of the pair becomes the key frame; returns what the longest motion since
  /// the key frame before has told of the sensor.
  std::optional<SensorEvidence> locate(const DepthPair& pair, const PairReader& reader, const PairPoints& of_pair,
                                       const SensorPrior& prior, const JointEstimate& motion);
  /// The current image is the reference of the next pair.
  void advance() { reference = current; }

 private:
  std::vector<JointPoint> stillSeen(const DepthPair& pair, const PairReader& reader, const PairPoints& of_pair,
                                    const RelativePose& chain);
  void begin(const DepthPair& pair, const PairPoints& of_pair, const JointEstimate& motion);
};

}  // namespace gms_ransac
