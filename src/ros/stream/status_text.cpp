#include "stream/status_text.h"

#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include <opencv2/core.hpp>

#include "gms_ransac/status_text.h"
#include "text.h"

namespace gms_ransac {

namespace {

/// Explains the outcome of a comparison. The status may differ from that of its result.
std::string explainPair(const ProcessedFrame& answer, const MatchFilterOptions& options) {
  const PreparedFrame& current = *answer.current;
  const cv::Mat& mask = current.mask;
  StatusCircumstances about;
  about.option_prefix = "~";
  about.features_asked = current.frame.features_asked;
  about.features_given = current.image.input.keypoints != nullptr;
  about.no_camera = current.image.camera->problem;
  // The mask is counted where it may be the reason.
  if (answer.status == MatchStats::TOO_FEW_KEYPOINTS && !mask.empty()) {
    about.unmasked = cv::countNonZero(mask) / static_cast<double>(mask.total());
  }
  if (current.image.values) {
    about.image_note = cv::format("its grey levels are those of the values %d to %d", current.image.values->low,
                                  current.image.values->high);
  }
  return explain(static_cast<Status>(answer.status), answer.pair->result, options, about);
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
      return explainPair(answer, options.core);
    case Why::kReset:
      return current.image.reset == Reset::kRequested
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
      return "the frame_id changed from '" + reason.detail + "' to '" + current.image.header.frame_id +
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
      text << "goes on from the image of " << answer.pair->reference->image.header.stamp << ", "
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

static_assert(static_cast<int>(Status::kUncalibrated) == MatchStats::UNCALIBRATED &&
                  static_cast<int>(Status::kMotionUnknown) == MatchStats::MOTION_UNKNOWN,
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
