#include "stream/status_text.h"

#include <sstream>

#include <gms_ransac/MatchStats.h>
#include <opencv2/core.hpp>

#include "quantity_text.h"
#include "stream/prepared_frame.h"

namespace gms_ransac {

namespace {

int usedPercent(const cv::Mat& mask) {
  return cvRound(100.0 * cv::countNonZero(mask) / static_cast<double>(mask.total()));
}

// Of the image; where a mask leaves less, it is the reason for few keypoints.
constexpr int kLittlePercent = 20;

/// Which of the two images has too few keypoints, and why.
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
  text << "rotation only, the direction of translation is not known: ";
  switch (result.robust.doubt) {
    case DirectionDoubt::kStill:
      text << "most matches show no translation, and what does may move by itself";
      break;
    case DirectionDoubt::kRotation:
      text << "the rotation is uncertain by more than a degree, as its covariance says";
      break;
    case DirectionDoubt::kDirection:
      text << "its standard deviation is above ~max_direction_sigma (" << options.max_direction_sigma << " degrees)";
      break;
    case DirectionDoubt::kOtherMotion:
      text << "another motion explains the " << result.matches_gms << " filtered matches as well, or part of them";
      break;
    default:
      text << std::fixed
           << "a turn, or one that goes on while the rows of an image are read, explains the matches as well ("
           << result.robust.median_parallax_px << " px of parallax where keypoints are off by "
           << result.robust.sigma_px << " px)";
  }
  return text.str();
}

/// What ~rolling_shutter_readout could not do for the pair, as the end of a sentence; empty: nothing to say.
std::string explainRows(const RobustResult& result, double readout) {
  const bool unknown = result.row_correction == RowCorrection::kUnknownTime;
  if (!unknown && result.row_correction != RowCorrection::kUnlikely) return std::string();
  return "; its rows count as read at once: " +
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
      return "no images were taken for a while (~pause, or nobody listened)";
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
      text << "only " << result.matches.size() << " matches; raise ~features";
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
