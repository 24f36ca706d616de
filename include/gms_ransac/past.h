// What a comparison knows of the pairs before it: the value that joins the pairs of a stream.
#pragma once

#include <optional>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// Given to MatchFilter::filter with each pair of a stream, which updates it; a stream starts with an empty one. Copy
/// it to try a pair that may not become part of the stream.
struct Past {
  std::optional<TwoViewPose> motion;  ///< of the last pair, where the next search starts
};

}  // namespace gms_ransac
