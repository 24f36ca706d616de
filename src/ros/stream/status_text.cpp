#include "stream/status_text.h"

#include <sstream>

#include <gms_ransac/MatchStats.h>
#include <opencv2/core.hpp>

#include "stream/prepared_frame.h"
#include "text.h"

namespace gms_ransac {

namespace {

int usedPercent(const cv::Mat& mask) {
  return cvRound(100.0 * cv::countNonZero(mask) / static_cast<double>(mask.total()));
}

// Share of the image below which a mask is the reason for few keypoints, percent.
constexpr int kLittlePercent = 20;

/// Names the image that has too few keypoints, and the reason.
std::string explainFewKeypoints(const MatchResult& result, const cv::Mat& mask) {
  std::ostringstream text;
  if (result.keypoints_current > result.keypoints_reference) {
    text << "only " << result.keypoints_reference << " keypoints in the reference image (this one has "
         << result.keypoints_current << "): it was dark, blurred, plain or masked";
    return text.str();
  }
  text << "only " << result.keypoints_current << " keypoints (the reference has " << result.keypoints_reference
       << "): ";
  const int used = mask.empty() ? 100 : usedPercent(mask);
  if (used < kLittlePercent) {
    text << "the mask leaves " << used << " % of the image (no keypoint is taken where it is zero)";
  } else {
    text << "the image is dark, blurred or plain; lower ~fast_threshold";
  }
  return text.str();
}

/// Why there is a rotation and no translation.
std::string explainLowParallax(const MatchResult& result, const RobustOptions& options) {
  std::ostringstream text;
  text.precision(3);
  text << "rotation only: ";
  switch (result.robust.doubt) {
    case DirectionDoubt::kMostlyStatic:
      text << "most matches show no translation, and the others may lie on moving objects";
      break;
    case DirectionDoubt::kRotation:
      text << "the rotation has a standard deviation above one degree, too much for a translation";
      break;
    case DirectionDoubt::kDirection:
      text << "the direction of translation has a standard deviation above ~max_direction_sigma ("
           << options.max_direction_sigma << " degrees)";
      break;
    case DirectionDoubt::kOtherMotion:
      text << "a second motion explains the " << result.matches_gms
           << " filtered matches as well, or part of them; a scene with more depth, a larger motion or a ~mask over "
              "moving "
              "objects decides";
      break;
    default:
      text << std::fixed << "a rotation, with a rolling shutter or without, explains the matches as well ("
           << result.robust.median_parallax_px << " px of parallax, " << result.robust.sigma_px
           << " px of keypoint noise)";
  }
  return text.str();
}

/// Why the pair was not corrected for the rolling shutter, as the end of a sentence; empty: it was, or no readout is
/// set.
std::string explainRows(const RobustResult& result, double readout) {
  const bool unknown = result.row_correction == RowCorrection::kUnknownTime;
  if (!unknown && result.row_correction != RowCorrection::kUnlikely) return std::string();
  return "; not corrected for the rolling shutter: " +
         (unknown ? "the images are less than ~rolling_shutter_readout (" + secondsText(readout) + ") apart"
                  : "the matches fit worse with ~rolling_shutter_readout (" + secondsText(readout) + ")");
}

}  // namespace

static_assert(static_cast<int>(Status::kUncalibrated) == MatchStats::UNCALIBRATED,
              "values of the core and the message");

std::string statusName(uint8_t status) {
  if (status == MatchStats::TIME_RESET) return "TIME_RESET";
  if (status == MatchStats::BAD_IMAGE) return "BAD_IMAGE";
  if (status == MatchStats::RECOVERED) return "RECOVERED";
  return toString(static_cast<Status>(status));
}

std::string explain(Reset reset) {
  switch (reset) {
    case Reset::kRequested:
      return "reset on request";
    case Reset::kUnsubscribed:
      return "no images were taken for a while (~pause, or no output had a subscriber)";
    default:
      return std::string();
  }
}

std::string explain(Status status, const MatchResult& result, const PreparedFrame& current) {
  std::ostringstream text;
  switch (status) {
    case Status::kOk:
      text << result.inliers << " of " << result.matches_gms << " filtered matches agree on one motion";
      break;
    case Status::kTooFewKeypoints:
      text << explainFewKeypoints(result, current.mask);
      break;
    case Status::kTooFewMatches:
      text << "only " << result.matches.size() << " matches: the views differ too much, or ~features is too small";
      break;
    case Status::kGmsRejected:
      text << "only " << result.matches_gms << " of " << result.matches.size()
           << " matches have support around them: the views differ too much, or ~features is too small for the grid";
      break;
    case Status::kRansacFailed:
      text << "no model explains enough of the " << result.matches_gms
           << " filtered matches: the views differ too much, or little of what is seen is rigid";
      break;
    case Status::kLowParallax:
      text << explainLowParallax(result, current.filter->options().robust);
      break;
    case Status::kUncalibrated:
      text << "correspondences only, no pose: " << current.camera->problem;
      break;
    default:
      text << toString(status);
  }
  text << explainRows(result.robust, current.filter->options().robust.rolling_shutter_readout);
  return text.str();
}

}  // namespace gms_ransac
