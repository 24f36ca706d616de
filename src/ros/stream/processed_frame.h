// Answer for one image: the comparison, its status with the reasons, its pose, and where it leaves the camera.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gms_ransac/MatchStats.h>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/triangulation.h"
#include "scale/learnt_sensor.h"
#include "stream/odometry.h"
#include "stream/prepared_frame.h"
#include "stream/shared_errors.h"

namespace gms_ransac {

/// How an image follows on what came before it.
enum class Continuity {
  kContinuous,
  kBroken,    ///< the motion since the image before is not known, and the place stays: a gap, another image size
  kRestarted  ///< nothing before counts any more: the clock or the stamps went back, or a reset was asked for
};

/// Why an answer is what it is; `words` (status_text.h) makes the sentences. Details are in brackets.
enum class Why : uint8_t {
  kCompared,  ///< what the comparison found; its numbers are those of the result
  // The image is not used [topic and problem], or the comparison threw [what].
  kUnusable,
  kFailed,
  // It is the first, or nothing before can be compared with it [the size before]; then it is a new reference.
  kFirst,
  kReset,
  kClockBack,
  kStampsBack,
  kGap,
  kReferenceOld,
  kNoneKept,
  kSizeChanged,
  kFrameChanged,        ///< the frame_id [before]
  kDescriptorsChanged,  ///< with ~input keypoints [kind before]
  kNewReference,
  kSizesDiffer,  ///< the two images of a pair [size of the reference]
  // After a loss: it goes on after a number of lost images, or not yet, with a number of images that are kept.
  kGoesOn,
  kKept,
  // The translation is measured [by what], has no length [why], or none since the loss; the pose is unfit [defect].
  kMeasured,
  kNoLength,
  kLengthUnknown,
  kUnfit,
  // Answered without a rotation prior [sentence], without a mask [why].
  kNoPrior,
  kNoMask,
  kDoubt  ///< calibration or units may be wrong [why]
};

struct Reason {
  Why why;
  std::string detail = std::string();
  int number = 0;
};

/// A current image compared with one reference. Columns have a row for each of `result.matches`.
struct ComparedPair {
  std::shared_ptr<PreparedFrame> reference;
  MatchResult result;
  std::vector<uint32_t> track_ids;  ///< 0: not followed
  std::vector<uint16_t> track_lengths;
  Triangulation points;       ///< of the inliers
  bool triangulated = false;  ///< else there is no pose, or no one needs the points
};

/// Owns all that it tells, so it outlives the stream's next steps.
struct ProcessedFrame {
  uint8_t status = MatchStats::FIRST_FRAME;
  std::vector<Reason> reasons;
  std::string text;  ///< `words` of the reasons
  std::shared_ptr<const PreparedFrame> current;
  std::shared_ptr<const ComparedPair> pair;  ///< null: not compared
  StageTimes times;                          ///< in all comparisons of the image
  Continuity continuity = Continuity::kContinuous;
  RelativePose pose;                      ///< as it is published; if poseValid()
  bool metric_scale = false;              ///< pose.t is in metres
  std::optional<RelativePose> uncertain;  ///< with ~publish_uncertain: uncertainPose of this answer
  /// The part of pose.covariance that is independent of other pairs, and the part that all share.
  Eigen::Matrix<double, 6, 6> own_covariance;
  SharedErrors shared = SharedErrors::Zero();
  std::optional<MotionSinceKey> since_key;  ///< with depth; covariance without shared errors, bounded as that of `pose`
  std::optional<LearntRig> rig;             ///< of two cameras
  std::optional<LearntOffset> offset;       ///< of a depth camera
  bool reference_held = false;              ///< the next image will be compared with this reference again
  /// After a loss the reference is an image from before it. `status` is what it would be without the loss.
  bool recovered = false;
  /// False if the time of the motion is not that between its stamps, or longer than ~max_frame_gap.
  bool velocity_known = true;
  /// Only with `recovered`: the length of the motion is unknown, `pose.t` is the direction alone.
  bool length_missing = false;
  std::string doubt;                      ///< why calibration or units may be wrong, and what to do; empty: no reason
  std::optional<MotionIntegrator> place;  ///< where the camera is with this image; none: not known
  bool place_restarted = false;           ///< the odometry frame is a new one, which begins with this image

  bool poseValid() const { return pair != nullptr && (status == MatchStats::OK || status == MatchStats::LOW_PARALLAX); }
  /// The pose in ~correspondences and ~relative_pose; null: none.
  const RelativePose* posePublished() const { return poseValid() ? &pose : uncertain ? &*uncertain : nullptr; }
  /// The camera stands still, and nothing measured how little it moved.
  bool atRest() const { return pair != nullptr && pair->result.stationary && !metric_scale; }
  /// As ~stats has it.
  uint8_t publishedStatus() const { return recovered ? static_cast<uint8_t>(MatchStats::RECOVERED) : status; }
};

}  // namespace gms_ransac
