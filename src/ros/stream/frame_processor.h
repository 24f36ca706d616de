// State of the stream: selects the reference of each image, compares and explains. Publishes nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "gms_ransac/match_filter.h"
#include "input/image_with_info.h"
#include "parameters.h"
#include "priors/motion_priors.h"
#include "stream/frame_preparation.h"
#include "stream/pair_pose.h"
#include "stream/processed_frame.h"
#include "stream/publishable_pose.h"
#include "stream/recovery.h"
#include "tracks/track_table.h"

namespace gms_ransac {

struct ProcessorOptions {
  MatchFilterOptions core;
  double max_frame_gap = 1;    ///< seconds
  bool hold_reference = true;  ///< keep the reference while the parallax is too small
  SigmaFloor sigma_floor;
  RecoveryOptions recovery;
};

/// When the features of an image are found.
enum class Extraction {
  kNow,
  kPutOff  ///< to `process`: the image may be passed over
};

/// `prepare` and `process` may run on two threads, each on one; the rest may be called from anywhere.
class FrameProcessor {
 public:
  /// Throws std::invalid_argument with a sentence when ~mask_file cannot be read. `priors`: other sensors; null: none.
  /// The topics appear in messages; those of the right camera with ~input stereo.
  FrameProcessor(const Parameters& parameters, const std::string& image_topic, const std::string& info_topic,
                 std::shared_ptr<MotionPriors> priors = nullptr, const std::string& right_topic = "right/image",
                 const std::string& right_info_topic = "right/camera_info");

  /// Takes effect with the next image. Throws std::invalid_argument and keeps the old options if these are wrong.
  void setOptions(const ProcessorOptions& options);
  /// The next image has nothing to be compared with.
  void requestReset(Reset why = Reset::kRequested);

  /// Conversion, stamp rules, extraction. Never throws.
  std::unique_ptr<PreparedFrame> prepare(const ImageWithInfo& input, Extraction extraction = Extraction::kNow);
  /// Comparison with the reference. Never throws. A reset that arrives with an unusable image applies to the next
  /// usable one.
  ProcessedFrame process(std::unique_ptr<PreparedFrame> frame);
  /// In place of `process`: the stream goes on as if the image had not come. It must be in order, ask for no reset and
  /// have no problem.
  void passOver(std::unique_ptr<PreparedFrame> frame);

 private:
  /// Keeps a frame that has served, for the next image; not one of a replaced filter, which may have found far more
  /// features.
  void keepSpare(std::unique_ptr<PreparedFrame> frame);

  // The stream: one image after the other.
  void processStream(ProcessedFrame& processed);
  void processPair(ProcessedFrame& processed);
  /// Forgets what came before where stamps or image size ask for it, and says why; false: compare.
  bool startAnew(const PreparedFrame& frame, ProcessedFrame& processed);
  /// `interval`: between this image and the one before.
  bool holdReference(const ProcessedFrame& processed, double interval);
  /// The current image becomes the reference.
  void advance(const ProcessedFrame& processed, bool compared);

  // One comparison.
  void compare(ProcessedFrame& processed);
  /// Matches, filters, estimates.
  void match(PreparedFrame& reference, MatchResult& result, const RotationPrior* prior = nullptr,
             Past* past = nullptr);
  /// If the calibration changed since the reference, moves its keypoints to where this image's camera shows them.
  void adoptCalibration(PreparedFrame& reference) const;
  /// Sets status, tracks and pose from `result_`.
  void conclude(ProcessedFrame& processed);
  void fail(const std::string& what, ProcessedFrame& processed);

  // After a loss, with ~recovery_frames.
  /// Continues from a kept image, or returns why not. False: the rest of processStream is to be done, as without.
  bool reenter(ProcessedFrame& processed);
  /// The way back is looked for in an image of which camera and options allow it.
  bool mayReenter(const PreparedFrame& frame) const;
  /// Compares with the kept images and goes on from one that shows the same; false: it is answered by a comparison with
  /// the image before, which belongs to the loss.
  bool compareWithKept(ProcessedFrame& processed);
  /// Index of the kept image that shows the same, with its `result_`; as many as there are, with that of the newest.
  size_t findKept();
  /// The reference is kept if its place is known; there is none any more.
  void retireReference();
  /// The same of a reference that the current image takes the place of.
  void keepReference(const ProcessedFrame& processed);
  double oldestReference() const;

  const std::string image_topic_;
  const std::shared_ptr<MotionPriors> priors_;
  FramePreparation preparation_;  ///< of `prepare`, and of `process` where features were put off

  // process's
  ProcessorOptions in_force_;  ///< for the current image
  std::unique_ptr<PreparedFrame> reference_, current_;
  MatchResult result_, kept_result_;
  Recovery recovery_;
  std::unique_ptr<PreparedFrame> dropped_;  ///< kept no longer; may serve the next image
  bool retired_ = false;                    ///< there was a reference, and there is none until an image is of use
  Past past_;
  TrackTable tracks_;
  PairPose pair_pose_;
  Reset reset_pending_ = Reset::kNone;  ///< of an unusable image, for the next usable one
  StampVerdict verdict_pending_ = StampVerdict::kInOrder;
  double last_stamp_ = 0;  ///< of the image processed before

  // shared
  std::mutex mutex_;
  std::shared_ptr<MatchFilter> filter_;
  ProcessorOptions options_;
  Reset reset_requested_ = Reset::kNone;
  std::unique_ptr<PreparedFrame> spare_;  ///< processed; its storage serves the next image
};

}  // namespace gms_ransac
