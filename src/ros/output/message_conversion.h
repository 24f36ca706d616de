// Results of an image -> messages.
#pragma once

#include <algorithm>

#include <gms_ransac/Correspondences.h>
#include <gms_ransac/MatchStats.h>

#include "stream/processed_frame.h"

namespace gms_ransac {

struct FrameCounters {
  uint32_t received = 0, processed = 0, passed_over = 0, dropped = 0, resets = 0;
};

/// Sets the fields pixel_space and K of a message.
template <typename Message>
void setCamera(const CameraModel& model, Message& message) {
  const bool calibrated = model.camera.calibrated();
  message.pixel_space = calibrated && model.rectified ? Message::PIXELS_RECTIFIED : Message::PIXELS_RAW;
  message.K.fill(0);
  if (!calibrated) return;
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> K = model.camera.K();
  std::copy(K.data(), K.data() + 9, message.K.begin());
}

/// `processed` must have been compared. With `with_rejected` every raw match is written and `stage` filled.
void toMessage(const ProcessedFrame& processed, bool with_rejected, Correspondences& message);

/// Does not set the latency.
void toMessage(const ProcessedFrame& processed, const FrameCounters& counters, MatchStats& message);

}  // namespace gms_ransac
