// The stream as a value: all that the answer to the next image depends on, besides the image.
#pragma once

#include <memory>
#include <optional>

#include "gms_ransac/past.h"
#include "scale/depth_pose.h"
#include "stream/motion_integrator.h"
#include "tracks/track_table.h"

namespace gms_ransac {

struct PreparedFrame;

/// Going back to an earlier image is assigning the Stream of then.
struct Stream {
  std::shared_ptr<PreparedFrame> reference;  ///< what the next image is compared with; null: nothing
  Past past;
  TrackTable tracks;
  ScalePropagator scale;
  KeyFrame key;  ///< of motions with depth
  MotionIntegrator place;
  std::optional<double> stamp;  ///< of the last image, seconds; none: the next is the first

  /// The next image is compared with nothing, and the motion up to it is not known. The place stays.
  void forget() {
    reference.reset();
    past = Past();
    tracks.reset();
    scale.reset();
    key = KeyFrame();
  }
};

}  // namespace gms_ransac
