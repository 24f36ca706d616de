// The stream on its two threads: images are prepared on one and answered on the other, with options and resets from
// anywhere. Publishes nothing.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "stream/prepared_frame.h"
#include "stream/step.h"

namespace gms_ransac {

/// `prepare` and `process` may run on two threads, each on one, and `setPlace` on that of `process`; the rest may be
/// called from anywhere.
class FrameProcessor {
 public:
  /// Throws std::invalid_argument with a sentence when ~mask_file cannot be read. `priors`: other sensors; null: none.
  /// The topics appear in messages; those of the right camera with ~input stereo.
  FrameProcessor(const Parameters& parameters, const std::string& image_topic, const std::string& info_topic,
                 std::shared_ptr<MotionPriors> priors = nullptr, const std::string& right_topic = "right/image",
                 const std::string& right_info_topic = "right/camera_info");

  /// Takes effect with the next image. Throws std::invalid_argument and keeps the old options if these are wrong.
  void setOptions(const ProcessorOptions& options);
  /// The next image that is of use has nothing to be compared with.
  void requestReset(Reset why = Reset::kRequested);

  /// Conversion, stamp rules and, unless it may be passed over, extraction. Never throws. A frame that is dropped
  /// instead of processed leaves the stream as if it had not come; it must be in order, ask for no reset and have no
  /// problem.
  std::shared_ptr<PreparedFrame> prepare(const ImageWithInfo& input, const Wanted& wanted = {});
  /// Comparison with the reference. Never throws.
  ProcessedFrame process(const std::shared_ptr<PreparedFrame>& frame);
  /// Sets the pose of the camera in the odometry frame at the last image. The pose before is forgotten.
  void setPlace(const Eigen::Isometry3d& pose, const Matrix6d& covariance);

 private:
  const std::string image_topic_;
  const Parameters parameters_;
  const std::shared_ptr<MotionPriors> priors_;
  FramePreparation preparation_;  ///< of `prepare`, and of `process` where features were put off

  // process's
  Stream stream_;
  Recovery recovery_;
  PairPool pairs_;
  StampVerdict verdict_pending_ = StampVerdict::kInOrder;  ///< of an image whose extraction failed, for the next

  std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<Pipeline> pipeline_;
  Reset reset_requested_ = Reset::kNone;
};

}  // namespace gms_ransac
