// The stream's state: which image is compared with which, and what is said when one cannot be. Publishes nothing.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <string>

#include <gms_ransac/MatchStats.h>
#include <std_msgs/Header.h>

#include "camera_model.h"
#include "gms_ransac/match_filter.h"
#include "gms_ransac/track_table.h"
#include "gms_ransac/translation_scale.h"
#include "image_conversion.h"
#include "image_with_info.h"
#include "mask_source.h"
#include "motion_priors.h"
#include "publishable_pose.h"
#include "recovery.h"
#include "stamp_watch.h"
#include "stereo_depth.h"

namespace gms_ransac {

/// One received image after the part of the work that needs no other image.
struct PreparedFrame {
  ImageWithInfo input;  ///< kept, because `grey` may share its memory
  std_msgs::Header header;
  cv::Mat grey;
  cv::Mat depth;  ///< CV_32FC1 metres; empty: none
  /// With ~input stereo; empty where the right image is of no use. Its depth is also that of an image with registered
  /// depth whose keypoints were moved (adoptCalibration).
  StereoColumns stereo;
  std::string depth_problem;  ///< why the depth image is not used; empty when it is, or when there is none
  cv::Mat mask;              ///< CV_8UC1, zero where no keypoint is taken; empty: none. May share the memory of `input`
  std::string mask_problem;  ///< why there is no mask although there should be one; empty when there need not be
  Frame frame;
  std::unique_ptr<PreparedFrame> pair_reference;  ///< with ~input pair: what this image is compared with
  std::shared_ptr<const CameraModel> camera;
  std::shared_ptr<MatchFilter> filter;  ///< with the options in force when the image came
  bool extracted = false;               ///< else the features, and what is made of them, are not found yet
  StampVerdict stamp_verdict = StampVerdict::kFirst;
  bool reset_requested = false;
  std::string problem;  ///< why the image is not used; empty when it is
  double convert_seconds = 0;
  double time_budget = 0;  ///< ~max_milliseconds in seconds

  double stamp() const { return header.stamp.toSec(); }
};

/// How an image follows on what came before it.
enum class Continuity {
  kContinuous,
  kBroken,    ///< the motion since the image before is not known: a gap, another image size
  kRestarted  ///< nothing before counts any more: the clock or the stamps went back, or a reset was asked for
};

/// What is to be published for one image. The pointers live until the next call of `process`.
struct ProcessedFrame {
  uint8_t status = MatchStats::FIRST_FRAME;
  std::string text;  ///< the status in words, with what to do where something can be done
  const PreparedFrame* current = nullptr;
  const PreparedFrame* reference = nullptr;  ///< null: not compared
  const MatchResult* result = nullptr;       ///< null: not compared
  Continuity continuity = Continuity::kContinuous;
  RelativePose pose;          ///< as it is published; if poseValid()
  bool metric_scale = false;  ///< pose.t is in metres
  /// Beside result->matches; 0: not followed.
  const std::vector<uint32_t>* track_ids = nullptr;
  const std::vector<uint16_t>* track_lengths = nullptr;
  bool reference_held = false;  ///< the next image will be compared with this reference again
  /// After a loss the reference is an image from before it. `status` is what it would be without the loss.
  bool recovered = false;
  /// Only with `recovered`: how far the camera moved is not known, `pose.t` says the direction alone.
  bool length_missing = false;
  double oldest_reference = kNoReference;  ///< no image of an earlier stamp will be a reference again, seconds
  static constexpr double kNoReference = std::numeric_limits<double>::infinity();

  bool poseValid() const {
    return result != nullptr && (status == MatchStats::OK || status == MatchStats::LOW_PARALLAX);
  }
  /// As ~stats has it.
  uint8_t publishedStatus() const { return recovered ? static_cast<uint8_t>(MatchStats::RECOVERED) : status; }
};

/// "OK", ..., "BAD_IMAGE": a value of MatchStats::status in words.
std::string statusName(uint8_t status);

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
  /// Throws std::invalid_argument with a sentence when ~mask_file cannot be read.
  /// `priors`: other sensors to ask; null: none. The topics of the right camera are for what is said of them, with
  /// ~input stereo.
  FrameProcessor(const Parameters& parameters, const std::string& image_topic, const std::string& info_topic,
                 std::shared_ptr<MotionPriors> priors = nullptr, const std::string& right_topic = "right/image",
                 const std::string& right_info_topic = "right/camera_info");

  /// Takes effect with the next image. Throws std::invalid_argument and keeps the old options if these are wrong.
  void setOptions(const ProcessorOptions& options);
  /// The next image has nothing to be compared with.
  void requestReset();

  /// Conversion, stamp rules, extraction. Never throws.
  std::unique_ptr<PreparedFrame> prepare(const ImageWithInfo& input, Extraction extraction = Extraction::kNow);
  /// Comparison with the reference. Never throws. What asks for a new start and comes with an image that is of no use
  /// is kept for the next one.
  ProcessedFrame process(std::unique_ptr<PreparedFrame> frame);
  /// In place of `process`: the stream goes on as if the image had not come. It must be in order, ask for no reset and
  /// have no problem.
  void passOver(std::unique_ptr<PreparedFrame> frame);

 private:
  /// An empty frame for the input, with the options in force now.
  std::unique_ptr<PreparedFrame> beginFrame(const ImageWithInfo& input);
  /// All but the features.
  void receive(PreparedFrame& frame);
  /// The features, and what is made of them, of an image that is of use; a problem where that fails.
  void findFeatures(PreparedFrame& frame);
  /// Sets the verdict; returns why the image is dropped, empty when it is not.
  std::string classifyStamp(PreparedFrame& frame);
  /// Of the current image.
  ProcessedFrame answer();
  ProcessedFrame processStream(ProcessedFrame processed);
  /// Forgets the reference where the stamps or the image size ask for it and says why; empty: compare.
  std::string startAnew(const PreparedFrame& frame, ProcessedFrame& processed);
  /// Keeps what an unusable image asks for.
  void keepPending(const PreparedFrame& frame);
  /// Hands it to the next usable one.
  void takePending(PreparedFrame& frame);
  void compare(ProcessedFrame& processed);
  /// Where the calibration changed since the reference, its keypoints go to where this image's camera shows them.
  void adoptCalibration(PreparedFrame& reference) const;
  /// Matches, filters, estimates.
  void match(PreparedFrame& reference, MatchResult& result, const RotationPrior* prior = nullptr);
  /// What follows from `result_`, which is that of the reference: status, tracks, pose.
  void conclude(ProcessedFrame& processed);
  void fail(const std::string& what, ProcessedFrame& processed);
  /// After a loss: goes on from a kept image, or says why not. False: the rest of processStream is to be done, as
  /// without ~recovery_frames.
  bool reenter(ProcessedFrame& processed);
  /// The way back is looked for in an image of which camera and options allow it.
  bool mayReenter(const PreparedFrame& frame) const;
  /// Compares with the kept images; false: it is answered by a comparison with the image before, which belongs to the
  /// loss.
  bool compareWithKept(ProcessedFrame& processed);
  /// Index of the kept image that shows the same, with its `result_`; as many as there are, with that of the newest.
  size_t findKept();
  void goOnFrom(size_t index, ProcessedFrame& processed);
  /// The reference is kept if its place is known; there is none any more.
  void retireReference();
  /// The same of a reference that the current image takes the place of.
  void keepReference(const ProcessedFrame& processed);
  double oldestReference() const;
  /// `interval`: between this image and the one before.
  bool holdReference(const ProcessedFrame& processed, double interval);
  ProcessedFrame processPair(ProcessedFrame processed);
  /// The metric pose of depth or of a second camera, where enough is known; says why not where it is not.
  void takeDepth(ProcessedFrame& processed, bool& translation_known);
  /// The comparison itself, with what other sensors say of it. Returns what is to be said of them; empty: nothing.
  std::string matchWithPriors();
  /// With a length that other sensors or the ground tell; says why there is none.
  void measureLength(ProcessedFrame& processed);
  /// Fills the pose, and the length of its translation as ~scale says.
  void finishPose(ProcessedFrame& processed);
  /// The last gate: a pose that is not fit to publish becomes RANSAC_FAILED, with what is wrong with it.
  void stopUnfitPose(ProcessedFrame& processed);
  /// The current image becomes the reference.
  void advance(const ProcessedFrame& processed, bool compared);
  /// The part of `prepare` that pairs and streams share; false, with `problem` set, when the image is of no use.
  bool convert(const sensor_msgs::ImageConstPtr& image, PreparedFrame& frame);
  /// What else than the image tells how far things are.
  void findDepth(PreparedFrame& frame);
  /// Finds the features where the mask lets them.
  void extract(MatchFilter& filter, PreparedFrame& frame);
  ProcessorOptions options();

  const std::string image_topic_;
  const Parameters parameters_;
  const std::shared_ptr<MotionPriors> priors_;

  // prepare's
  ImageConverter converter_;
  CameraModelSource camera_source_;
  StampWatch stamps_;

  std::mutex features_mutex_;  ///< guards what follows: process finds the features that were put off
  MaskSource mask_source_;
  StereoDepth stereo_depth_;

  // process's
  std::unique_ptr<PreparedFrame> reference_, current_;
  MatchResult result_, kept_result_;
  Recovery recovery_;
  std::unique_ptr<PreparedFrame> dropped_;  ///< kept no longer; may serve the next image
  bool retired_ = false;                    ///< there was a reference, and there is none until an image is of use
  TrackTable tracks_;
  ScalePropagator propagator_;
  Triangulation triangulation_;
  bool reset_pending_ = false;  ///< asked for with an image that was of no use, as is the next one
  StampVerdict verdict_pending_ = StampVerdict::kInOrder;
  bool scale_updated_ = false;  ///< the propagator knows the features of the last pair
  double last_stamp_ = 0;       ///< of the image processed before

  // shared
  std::mutex mutex_;
  std::shared_ptr<MatchFilter> filter_;
  ProcessorOptions options_;
  bool reset_requested_ = false;
  std::unique_ptr<PreparedFrame> spare_;  ///< processed; its storage serves the next image
};

}  // namespace gms_ransac
