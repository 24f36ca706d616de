// The stream on its two threads: an image is received, prepared and answered, with options and resets from anywhere.
// Publishes nothing.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "stream/prepared_frame.h"
#include "stream/step.h"

namespace gms_ransac {

/// `receive` and `process` may run on two threads, each on one, and `setPlace` on that of `process`; the rest may be
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

  // None of the three stages throws.
  /// Conversion and stamp rules. An image that is dropped instead of prepared leaves the stream as if it had not come;
  /// it must be in order, ask for no reset and have no problem.
  Received receive(const ImageWithInfo& input, const Wanted& wanted = {});
  /// Extraction. `right_keypoints`: with ~input stereo the depth of the keypoints is wanted.
  Prepared prepare(Received received, bool right_keypoints = true);
  /// Comparison with the reference.
  ProcessedFrame process(const Prepared& prepared);
  /// Sets the pose of the camera in the odometry frame at the last image. The pose before is forgotten.
  void setPlace(const Eigen::Isometry3d& pose, const Matrix6d& covariance);

 private:
  /// Called once for each image that is prepared: the mask after the image `kMaskDelay` before it, which is
  /// answered by then in any order of the threads. Nothing after a reset, stamps that restart or another camera.
  LearnedMask maskOf(const ReceivedImage& image);

  static constexpr size_t kMaskDelay = 3;
  const std::string image_topic_;
  const Parameters parameters_;
  const std::shared_ptr<MotionPriors> priors_;
  FramePreparation preparation_;

  // process's
  Stream stream_;
  Recovery recovery_;
  PairPool pairs_;
  StampVerdict verdict_pending_ = StampVerdict::kInOrder;  ///< of an image whose extraction failed, for the next

  std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<Pipeline> pipeline_;
  Reset reset_requested_ = Reset::kNone;
  std::array<LearnedMask, kMaskDelay + 1> masks_;  ///< after the last images that were answered
  size_t prepared_ = 0, answered_ = 0;             ///< images
  size_t first_of_camera_ = 0;                     ///< image since which nothing began anew
  std::string frame_id_;                           ///< of the camera
};

}  // namespace gms_ransac
