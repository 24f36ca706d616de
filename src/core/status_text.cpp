// A new status has its value in match_result.h and MatchStats.msg, its name and its sentence here. The switches have no
// default, so that the compiler names those that miss it.
#include "gms_ransac/status_text.h"

#include <cmath>

#include <opencv2/core.hpp>

namespace gms_ransac {

namespace {

/// Share of the image below which a mask is the reason for few keypoints.
constexpr double kLittle = 0.2;

std::string explainFewKeypoints(const MatchResult& result, const MatchFilterOptions& options,
                                const StatusCircumstances& about) {
  const char* prefix = about.option_prefix.c_str();
  const int asked = about.features_asked < 0 ? options.extractor.features : about.features_asked;
  const int here = result.keypoints_current, there = result.keypoints_reference;
  if (!about.features_given && asked < kMinimumMatches) {
    return cv::format("%sfeatures is %d, but a pair needs %d keypoints, and a good pose hundreds; raise it", prefix,
                      asked, kMinimumMatches);
  }
  if (here > there) {
    return cv::format(
        "only %d keypoints in the reference image (this one has %d): it was dark, blurred, plain or masked", there,
        here);
  }
  return cv::format("only %d keypoints (the reference has %d): ", here, there) +
         (about.unmasked < kLittle
              ? cv::format("the mask leaves %d %% of the image (no keypoint is taken where it is zero)",
                           cvRound(100 * about.unmasked))
          : about.features_given
              ? "the detector that made them found no more"
              : "the image is dark, blurred or plain; set " + about.option_prefix + "fast_threshold to 0") +
         (about.image_note.empty() ? "" : " (" + about.image_note + ")");
}

/// Why there is no translation, and perhaps no rotation either.
std::string explainDoubt(const MatchResult& result, const RobustOptions& options, const char* prefix) {
  const RobustResult& robust = result.robust;
  switch (robust.judgement.doubt) {
    case DirectionDoubt::kMostlyStatic:
      return "most matches show no translation, and the others may lie on moving objects";
    case DirectionDoubt::kRotation:
      return "the rotation has too large a standard deviation for a translation to be known";
    case DirectionDoubt::kDirection:
      return cv::format(
          "the direction of translation has too large a standard deviation beside %smax_direction_sigma (%.3g degrees)",
          prefix, options.max_direction_sigma);
    case DirectionDoubt::kVotes:
      return "distinctive matches all over the view do not agree with the motion that most matches have";
    case DirectionDoubt::kOtherMotion:
      return cv::format(
          "a second motion explains the %d filtered matches as well, or part of them; a scene with more depth, a "
          "larger motion or a %smask over moving objects decides",
          result.size(), prefix);
    case DirectionDoubt::kUnconfirmed:
      return "the direction of translation is not that of the pair before, and too uncertain to stand alone";
    case DirectionDoubt::kFixedToCamera:
      return cv::format(
          "a part of the view stays in place while the rest moves; a %smask over what is fixed to the camera (text, a "
          "bonnet, an arm) decides",
          prefix);
    case DirectionDoubt::kNone:
    case DirectionDoubt::kRotationExplains:
      break;
  }
  return cv::format(result.stationary
                        ? "the camera is at rest (%.3f px of parallax, %.3f px of keypoint noise)"
                        : "a rotation, with a rolling shutter or without, explains the matches as well (%.3f px of "
                          "parallax, %.3f px of keypoint noise)",
                    robust.judgement.median_parallax_px, robust.judgement.sigma_px);
}

std::string explainRansacFailed(const MatchResult& result) {
  return cv::format(
      "no model explains enough of the %d filtered matches: the views differ too much, or little of what is seen is "
      "rigid",
      result.size());
}

/// Why the pair was not corrected for the rolling shutter, as the end of a sentence; empty: it was, or no readout is
/// known.
std::string explainRows(const RobustResult& result, double readout, const char* prefix) {
  if (result.row_correction == RowCorrection::kUnknownTime) {
    return cv::format(
        "; not corrected for the rolling shutter: the images are less than %srolling_shutter_readout (%.3g s) apart",
        prefix, readout);
  }
  if (result.row_correction == RowCorrection::kUnlikely) {
    return "; not corrected for the rolling shutter: the matches fit worse with " +
           (readout < 0 ? "the readout that was learnt"
                        : cv::format("%srolling_shutter_readout (%.3g s)", prefix, readout));
  }
  return std::string();
}

std::string sentence(Status status, const MatchResult& result, const MatchFilterOptions& options,
                     const StatusCircumstances& about) {
  const char* prefix = about.option_prefix.c_str();
  const auto raw = static_cast<int>(result.raw.size());
  switch (status) {
    case Status::kOk:
      return cv::format("%d of %d filtered matches agree on one motion", result.inliers, result.size());
    case Status::kFirstFrame:
      return "first image; nothing to compare with yet";
    case Status::kTooFewKeypoints:
      return explainFewKeypoints(result, options, about);
    case Status::kTooFewMatches:
      return cv::format("only %d matches: the views differ too much, or %sfeatures is too small", raw, prefix);
    case Status::kGmsRejected:
      return cv::format(
          "only %d of %d matches have support around them: the views differ too much, or %sfeatures is too small for "
          "the grid",
          result.size(), raw, prefix);
    case Status::kRansacFailed:
      return explainRansacFailed(result);
    case Status::kLowParallax:
      return "rotation only: " + explainDoubt(result, options.robust, prefix);
    case Status::kUncalibrated:
      return "correspondences only, no pose: " + about.no_camera;
    case Status::kMotionUnknown:
      if (result.robust.judgement.doubt == DirectionDoubt::kFixedToCamera) {
        return explainDoubt(result, options.robust, prefix);
      }
      return cv::format(
          "the %d filtered matches agree on a motion, but different rotations explain them as well: take images "
          "further apart, or of a scene with more depth",
          result.size());
  }
  return toString(status);
}

}  // namespace

std::string toString(Status status) {
  switch (status) {
    case Status::kOk:
      return "OK";
    case Status::kFirstFrame:
      return "FIRST_FRAME";
    case Status::kTooFewKeypoints:
      return "TOO_FEW_KEYPOINTS";
    case Status::kTooFewMatches:
      return "TOO_FEW_MATCHES";
    case Status::kGmsRejected:
      return "GMS_REJECTED";
    case Status::kRansacFailed:
      return "RANSAC_FAILED";
    case Status::kLowParallax:
      return "LOW_PARALLAX";
    case Status::kUncalibrated:
      return "UNCALIBRATED";
    case Status::kMotionUnknown:
      return "MOTION_UNKNOWN";
  }
  return "UNKNOWN";
}

std::string explain(Status status, const MatchResult& result, const MatchFilterOptions& options,
                    const StatusCircumstances& about) {
  return sentence(status, result, options, about) +
         explainRows(result.robust, options.robust.rolling_shutter_readout, about.option_prefix.c_str());
}

}  // namespace gms_ransac
