#include "stream/status_text.h"

#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include <opencv2/core.hpp>

#include "text.h"

namespace gms_ransac {

namespace {

// Share of the image below which a mask is the reason for few keypoints, percent.
constexpr int kLittlePercent = 20;

/// Names the image that has too few keypoints, and the reason.
std::string explainFewKeypoints(const MatchResult& result, const PreparedFrame& current) {
  const cv::Mat& mask = current.mask;
  const bool given = current.input.keypoints != nullptr;
  const std::optional<ValueRange>& values = current.values;
  const int asked = current.frame.features_asked;
  const int here = result.keypoints_current, there = result.keypoints_reference;
  if (!given && asked < kMinimumMatches) {
    return cv::format("~features is %d, but a pair needs %d keypoints, and a good pose hundreds; raise it", asked,
                      kMinimumMatches);
  }
  if (here > there) {
    return cv::format(
        "only %d keypoints in the reference image (this one has %d): it was dark, blurred, plain or masked", there,
        here);
  }
  const int used = mask.empty() ? 100 : cvRound(100.0 * cv::countNonZero(mask) / static_cast<double>(mask.total()));
  return cv::format("only %d keypoints (the reference has %d): ", here, there) +
         (used < kLittlePercent
              ? cv::format("the mask leaves %d %% of the image (no keypoint is taken where it is zero)", used)
          : given ? "the detector that publishes them found no more"
                  : "the image is dark, blurred or plain; set ~fast_threshold to 0") +
         (values ? cv::format(" (its grey levels are those of the values %d to %d)", values->low, values->high) : "");
}

/// Why there is a rotation and no translation.
std::string explainLowParallax(const MatchResult& result, const RobustOptions& options) {
  switch (result.robust.doubt) {
    case DirectionDoubt::kMostlyStatic:
      return "most matches show no translation, and the others may lie on moving objects";
    case DirectionDoubt::kRotation:
      return "the rotation has a standard deviation above one degree, too much for a translation";
    case DirectionDoubt::kDirection:
      return cv::format(
          "the direction of translation has a standard deviation above ~max_direction_sigma (%.3g degrees)",
          options.max_direction_sigma);
    case DirectionDoubt::kOtherMotion:
      return cv::format(
          "a second motion explains the %d filtered matches as well, or part of them; a scene with more "
          "depth, a larger motion or a ~mask over moving objects decides",
          result.size());
    case DirectionDoubt::kDiscontinuity:
      return "the direction of translation breaks with the motion before, and what was static until now does not show "
             "it; something that moves by itself may fill the view";
    case DirectionDoubt::kUnconfirmed:
      return cv::format(
          "the direction of translation is not that of the pair before, and its standard deviation is above half of "
          "~max_direction_sigma (%.3g degrees)",
          options.max_direction_sigma / 2);
    default:
      if (result.stationary) {
        return cv::format("the camera is at rest (%.3f px of parallax, %.3f px of keypoint noise)",
                          result.robust.median_parallax_px, result.robust.sigma_px);
      }
      return cv::format(
          "a rotation, with a rolling shutter or without, explains the matches as well (%.3f px of "
          "parallax, %.3f px of keypoint noise)",
          result.robust.median_parallax_px, result.robust.sigma_px);
  }
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

/// Explains the outcome of a comparison, with the remedy. `status` may differ from that of `result`.
std::string explain(Status status, const MatchResult& result, const PreparedFrame& current,
                    const RobustOptions& options) {
  const auto raw = static_cast<int>(result.raw.size());
  const auto words = [&]() -> std::string {
    switch (status) {
      case Status::kOk:
        return cv::format("%d of %d filtered matches agree on one motion", result.inliers, result.size());
      case Status::kTooFewKeypoints:
        return explainFewKeypoints(result, current);
      case Status::kTooFewMatches:
        return cv::format("only %d matches: the views differ too much, or ~features is too small", raw);
      case Status::kGmsRejected:
        return cv::format(
            "only %d of %d matches have support around them: the views differ too much, or ~features is "
            "too small for the grid",
            result.size(), raw);
      case Status::kRansacFailed:
        if (result.robust.doubt == DirectionDoubt::kDiscontinuity) {
          return "the direction of translation breaks with the motion before, and too little of what was static until "
                 "now is seen to confirm it; something that moves by itself may fill the view";
        }
        return cv::format(
            "no model explains enough of the %d filtered matches: the views differ too much, or little "
            "of what is seen is rigid",
            result.size());
      case Status::kLowParallax:
        return "rotation only: " + explainLowParallax(result, options);
      case Status::kUncalibrated:
        return "correspondences only, no pose: " + current.camera->problem;
      default:
        return toString(status);
    }
  };
  return words() + explainRows(result.robust, options.rolling_shutter_readout);
}

/// Beginnings of the sentences that end with the detail of the reason.
const std::map<Why, std::string> kBeginnings = {{Why::kUnusable, "image on "},
                                                {Why::kClockBack, "the clock went back"},
                                                {Why::kStampsBack, "the stamps went back"},
                                                {Why::kFirst, "first image; nothing to compare with yet"},
                                                {Why::kNewReference, "this image is a new reference"},
                                                {Why::kMeasured, "the translation is measured by the "},
                                                {Why::kNoLength, "no length: "},
                                                {Why::kLengthUnknown, "the length of the motion since then is unknown"},
                                                {Why::kUnfit, "the pose is not fit to publish: "},
                                                {Why::kFailed, ""},
                                                {Why::kNoPrior, ""},
                                                {Why::kNoMask, "no mask: "},
                                                {Why::kDoubt, "doubtful: "}};

std::string sentence(const Reason& reason, const ProcessedFrame& answer, const ProcessorOptions& options) {
  const auto max_gap = [&] { return "~max_frame_gap (" + secondsText(options.max_frame_gap) + ")"; };
  const PreparedFrame& current = *answer.current;
  switch (reason.why) {
    case Why::kCompared:
      return explain(static_cast<Status>(answer.status), answer.pair->result, current, options.core.robust);
    case Why::kReset:
      return current.reset == Reset::kRequested
                 ? "reset on request"
                 : "no images were taken for a while (~pause, or no output had a subscriber)";
    case Why::kGap:
      return "more than " + max_gap() + " since the image before; raise it for a slow camera";
    case Why::kNoneKept:
      return "no image from before the loss is kept any more: they are of another size, or older than "
             "~max_recovery_gap (" +
             secondsText(options.recovery.seconds) + ")";
    case Why::kSizeChanged:
      return "the image size changed from " + reason.detail + " to " + sizeText(current.imageSize());
    case Why::kFrameChanged:
      return "the frame_id changed from '" + reason.detail + "' to '" + current.header.frame_id +
             "', which is another camera; if they alternate, two cameras publish the topic: give each a filter of its "
             "own";
    case Why::kDescriptorsChanged:
      return "the descriptors changed from " + reason.detail + " to " + current.frame.features.descriptors.kind() +
             ", which cannot be compared";
    case Why::kReferenceOld:
      return "the last usable image is older than " + max_gap() + "; raise it for a slow camera";
    case Why::kSizesDiffer:
      return "the two images differ in size: " + reason.detail + " and " + sizeText(current.imageSize());
    case Why::kGoesOn: {
      std::ostringstream text;
      text << "goes on from the image of " << answer.pair->reference->header.stamp << ", "
           << secondsText(current.stamp() - answer.pair->reference->stamp()) << " and " << reason.number
           << " lost images ago";
      return text.str();
    }
    case Why::kKept:
      return "images from before the loss are kept: " + std::to_string(reason.number);
    default:
      return kBeginnings.at(reason.why) + reason.detail;
  }
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

std::string words(const ProcessedFrame& answer, const ProcessorOptions& options) {
  std::string text;
  const char* joint = "";
  for (const Reason& reason : answer.reasons) {
    std::string next = sentence(reason, answer, options);
    text = text.empty() ? std::move(next) : text + joint + next;
    joint = reason.why == Why::kGoesOn ? ": " : "; ";
  }
  return text;
}

}  // namespace gms_ransac
