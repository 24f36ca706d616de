// The value that joins the pairs of a stream: it holds what a comparison uses of the pairs before it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/features.h"
#include "gms_ransac/learned_mask.h"
#include "gms_ransac/relative_pose.h"
#include "gms_ransac/shutter.h"

namespace gms_ransac {

/// Given to MatchFilter::filter with each pair of a stream, which reads and updates it; a stream starts with an empty
/// one. The reference may be the current image of the last pair, its reference once more, or neither: the features show
/// which. Copy it to try a pair that may not become part of the stream.
struct Past {
  std::optional<MotionStart> motion;  ///< of the last pair, where the next search starts
  /// Directions of translation: the last known one, and that of the last pair, known or not; zero: none. In the axes of
  /// the pair's reference, then in those of the last current image.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero(), guess = Eigen::Vector3d::Zero();
  Eigen::Vector3d current_direction = Eigen::Vector3d::Zero(), current_guess = Eigen::Vector3d::Zero();
  int steady = 0;           ///< pairs for which `direction` is still expected; 0: it is not known
  ShutterEstimate shutter;  ///< the camera's, by all pairs of the stream
  /// 1 for each keypoint that the motion explained, in the reference and in the current image of the last pair.
  std::vector<uint8_t> reference_static, current_static;
  uint64_t reference_image = 0, current_image = 0;  ///< fingerprints of these images; 0: none
  LearnedMask mask;                                 ///< what is fixed to the camera, by all pairs of the stream

  /// True for a keypoint of the reference that the last motion explained.
  bool isStatic(int32_t keypoint) const {
    const auto k = static_cast<size_t>(keypoint);
    return k < reference_static.size() && reference_static[k] != 0;
  }
  /// Called by MatchFilter::filter: moves on to this pair. Its reference inherits from the last pair's current image,
  /// or from its reference; another image inherits nothing.
  void startPair(const Features& reference, const Features& current);
};

}  // namespace gms_ransac
