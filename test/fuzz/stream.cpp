// A schedule of images, copies, resets, clock jumps and reconfigurations against the node's frame processor: one answer
// for each image, every one of them sound and fit to publish. And stamps of any order against the verdicts on them.
#include <cmath>
#include <optional>

#include "fuzz_answers.h"
#include "fuzz_messages.h"
#include "input/stamp_watch.h"
#include "methods/method.h"
#include "output/message_conversion.h"
#include "output/overlay.h"
#include "output/point_messages.h"

namespace gms_ransac {
namespace {

/// The new verdict by the one before and what separates the stamps (stamp_watch.h).
void checkStamps(FuzzInput& input) {
  StampWatch watch;
  double stamp = 1000, now = 1000, gap = 1;
  std::optional<double> late;  // the last stamp of those dropped since one was used, if it was older than that
  int clock_set_back = 0;
  bool newer_dropped = false;
  for (bool first = true; !input.empty(); first = false) {
    const double before = watch.previousStamp(), stamp_before = stamp, now_before = now;
    if (input.byte() > 240) gap = input.within(0.001, 5);
    stamp = std::clamp(stamp + (input.byte() < 224 ? input.within(-0.1, 0.3) : input.within(-10, 10)), 1.0, 4e9);
    now = std::clamp(now + (input.byte() < 240 ? input.within(0, 0.3) : input.within(-10, 10)), 1.0, 4e9);
    if (input.byte() > 240) stamp = before;
    clock_set_back += now < now_before;
    const StampVerdict verdict = watch.judge(stamp, now, gap);
    const bool dropped = verdict == StampVerdict::kOutOfOrder;
    demand(watch.previousStamp() == (dropped ? before : stamp), "an image that is dropped does not move the watch");
    demand((verdict == StampVerdict::kFirst) == first, "the first image is the first");
    if (first) continue;
    const double step = stamp - before;
    const bool in_order = verdict == StampVerdict::kInOrder || verdict == StampVerdict::kAfterLate;
    demand(in_order == (step > 0 && step <= gap), "a step up to the gap is in order");
    demand((verdict == StampVerdict::kGap) == (step > gap), "a longer one is a gap");
    demand(!in_order || (verdict == StampVerdict::kAfterLate) == late.has_value(), "an image that was late is said");
    const bool restarted = verdict == StampVerdict::kJumpedBack || verdict == StampVerdict::kClockReset;
    demand(restarted || step >= -gap, "a step back beyond the gap is a restart");
    demand(!restarted || step < -gap || clock_set_back > 0, "a shorter one is none while the clock goes on");
    if (verdict == StampVerdict::kClockReset) demand(--clock_set_back >= 0, "a clock that was set is said once");
    const bool set_back = verdict == StampVerdict::kSteppedBack;
    demand(!set_back || (step < 0 && late && stamp > *late), "two late images in order show a clock that was set back");
    const bool newer = stamp > stamp_before;
    demand(!newer || !dropped || !newer_dropped, "a stream that goes on is used");
    newer_dropped = newer && dropped;
    if (!dropped) late.reset();
    if (dropped && step < 0) late = stamp;
  }
}

class Schedule {
 public:
  explicit Schedule(FuzzInput& input)
      : input_(input), parameters_(fuzzedParameters(input)), processor_(parameters_, "/image", "/camera_info") {
    reconfigure();
  }

  void step() {
    const int kind = input_.between(0, 15);
    if (kind == 0) {
      processor_.requestReset();
      reset_ = true;
    } else if (kind == 1) {
      jump(clock_, 100);
    } else if (kind == 2) {
      jump(stamp_, 5);
    } else if (kind == 3) {
      reconfigure();
    } else {
      image();
    }
  }

 private:
  static Parameters fuzzedParameters(FuzzInput& input) {
    Parameters parameters;
    parameters.scale = static_cast<ScaleMode>(input.between(0, 3));
    parameters.input = input.byte() > 224 ? InputKind::kPair : InputKind::kStream;
    if (input.flag()) parameters.camera = {100, 100, kWallWidth / 2.0, kWallHeight / 2.0, "", {}};
    return parameters;
  }

  void jump(double& seconds, double most) {
    seconds += input_.number(-most, most);
    if (!(seconds > 0 && seconds < 4e9)) seconds = 1000;
  }

  void reconfigure() {
    ProcessorOptions options;
    options.core.method = input_.oneOf(methods()).name;
    options.core.extractor.features = input_.between(1, 300);
    options.core.extractor.pyramid_levels = input_.between(1, 4);
    options.core.robust.max_iterations = input_.between(1, 50);
    options.core.robust.model = static_cast<ModelType>(input_.between(0, 2));
    options.core.robust.judge = input_.byte() < 192;
    options.core.one_to_one = input_.flag();
    options.max_frame_gap = input_.number(0.001, 5);
    options.hold_reference = input_.flag();
    if (input_.byte() > 240) options.core.extractor.features = input_.raw<int32_t>();
    try {
      processor_.setOptions(options);
    } catch (const std::invalid_argument&) {
      // The old options stay; there are none yet at the start.
      if (!configured_) processor_.setOptions(ProcessorOptions());
    }
    configured_ = true;
  }

  struct Shown {
    sensor_msgs::ImagePtr message;
    bool wall = false;  ///< all of it is a view of the wall, so no row is of one colour
  };

  /// Sometimes with rows of the image before it.
  Shown nextImage(const Shown& before) {
    static const std::vector<std::string> kEncodings = {"mono8", "bgr8", "mono16", "yuv422", "bayer_rggb8"};
    const uint8_t kind = input_.byte();
    if (kind > 224) return {fuzzedImage(input_, kEncodings, 160)};
    const sensor_msgs::ImagePtr image = wallView(input_.byte(), input_.between(0, 3) * 8);
    if (kind > 208) image->data.resize(image->data.size() / 2);
    if (kind < 64 && before.wall) {
      const int begin = input_.between(0, kWallHeight) * kWallWidth;
      const int end =
          input_.between(0, 2) > 0 ? kWallHeight * kWallWidth : begin + (kWallHeight * kWallWidth - begin) / 2;
      std::copy(before.message->data.begin() + begin, before.message->data.begin() + end, image->data.begin() + begin);
    }
    return {image, kind <= 208};
  }

  void image() {
    ImageWithInfo with_info;
    const bool pair = parameters_.input == InputKind::kPair;
    const Shown before = pair ? nextImage({}) : before_, shown = nextImage(before);
    const sensor_msgs::ImagePtr image = shown.message;
    stamp_ += input_.within(0, 0.2);
    clock_ += 0.1;
    image->header.stamp = ros::Time(stamp_);
    image->header.frame_id = input_.byte() > 240 ? input_.text(20) : "camera";
    with_info.image = image;
    if (input_.byte() > 128) with_info.camera_info = fuzzedCameraInfo(input_, kWallWidth, kWallHeight);
    if (input_.byte() > 200) with_info.mask = fuzzedImage(input_, std::vector<std::string>{"mono8"}, 160);
    if (parameters_.scale == ScaleMode::kDepth && input_.flag()) with_info.depth = depth();
    if (pair) with_info.reference = before.message;
    with_info.received = ros::Time(clock_);
    const Prepared prepared = processor_.prepare(processor_.receive(with_info));
    demand(prepared.frame != nullptr, "an image is prepared");
    const ProcessedFrame processed = processor_.process(prepared);
    checkCopy(processed, before, shown);
    check(processed, *image);
  }

  /// Half of the rows make a copy, but at a new beginning.
  void checkCopy(const ProcessedFrame& processed, const Shown& before, const Shown& shown) {
    const StampVerdict verdict = processed.current->image.stamp_verdict;
    const bool late = verdict == StampVerdict::kOutOfOrder;
    if (before.wall && shown.wall) {
      int equal = 0;
      for (int at = 0; at < kWallHeight * kWallWidth; at += kWallWidth) {
        const auto *a = &before.message->data[static_cast<size_t>(at)],
                   *b = &shown.message->data[static_cast<size_t>(at)];
        equal += std::equal(a, a + kWallWidth, b);
      }
      const bool stream = parameters_.input == InputKind::kStream;
      const bool begins = stream && (reset_ || verdict > StampVerdict::kSteppedBack);
      const bool refused = processed.status == MatchStats::BAD_IMAGE &&
                           processed.text.find("copy of the image before it") != std::string::npos;
      demand(refused == (2 * equal >= kWallHeight && !begins && !late), "a copy is refused, and nothing else as one");
    }
    if (!late) before_ = shown;
  }

  sensor_msgs::ImagePtr depth() {
    cv::Mat_<float> metres(kWallHeight, kWallWidth, input_.number32(0.1f, 10));
    for (int i = 0; i < kWallWidth * kWallHeight; i += 11) metres(i / kWallWidth, i % kWallWidth) = 0;
    return cv_bridge::CvImage({}, "32FC1", metres).toImageMsg();
  }

  void check(const ProcessedFrame& processed, const sensor_msgs::Image& image) {
    demand(processed.current != nullptr, "an answer is about an image");
    demand(processed.current->image.header.stamp == image.header.stamp, "about the image that was given");
    demandSound(processed);
    demand(processed.status <= MatchStats::MOTION_UNKNOWN, "a status is known");
    if (processed.status != MatchStats::BAD_IMAGE) checkOrder(processed);
    MatchStats stats;
    toMessage(processed, {}, stats);
    demand(std::isfinite(stats.time_total) && std::isfinite(stats.rms_error_px) && std::isfinite(stats.inlier_ratio) &&
               std::isfinite(stats.median_parallax_px) && std::isfinite(stats.sigma_px) &&
               std::isfinite(stats.camera_misfit),
           "every figure is finite");
    if (processed.pair == nullptr) {
      demand(!processed.poseValid(), "no pose without a comparison");
      return;
    }
    checkCompared(processed);
  }

  /// Stamps grow, or the stream reports a restart.
  void checkOrder(const ProcessedFrame& processed) {
    const double stamp = processed.current->stamp();
    if (parameters_.input == InputKind::kStream) {
      const bool new_start = processed.continuity == Continuity::kRestarted;
      const bool set_back = processed.status == MatchStats::TIME_RESET;  // by less than ~max_frame_gap: the place stays
      demand(new_start || set_back || !(stamp <= last_used_), "stamps grow, or a restart is said");
      if (reset_) demand(new_start, "a reset is done");
      last_used_ = stamp;
    }
    reset_ = false;
  }

  void checkCompared(const ProcessedFrame& processed) {
    const MatchResult& result = processed.pair->result;
    if (result.raw.empty()) return;
    for (const bool with_rejected : {false, true}) {
      Correspondences message;
      toMessage(processed, with_rejected, message);
      const size_t n = with_rejected ? result.raw.size() : static_cast<size_t>(result.inliers);
      demand(message.confidence.size() == n && message.reference_points.size() == 2 * n &&
                 message.track_id.size() == n && message.current_sigma.size() == n,
             "columns of the message agree in length");
      for (const float sigma : message.current_sigma) demand(std::isfinite(sigma) && sigma >= 0, "a sigma is finite");
      for (const double k : message.K) demand(std::isfinite(k), "K is finite");
      if (message.pose_valid) {
        for (const double c : message.current_in_reference.covariance)
          demand(std::isfinite(c), "a covariance is finite");
      }
    }
    overlay_.add(processed);
    overlay_.draw(processed,
                  {static_cast<OverlayColour>(input_.between(0, 4)), static_cast<OverlayLayout>(input_.flag())});
    if (processed.current->image.camera->camera.calibrated()) markerMessage(processed);
    if (!processed.poseValid() || !processed.place) return;
    const OdometryEstimate camera = processed.place->camera();
    demand(camera.pose.matrix().allFinite() && camera.twist.allFinite(), "odometry is finite");
    demandEmpty(brokenCovariance(camera.pose_covariance, kPublishedRounding));
    demandEmpty(brokenCovariance(camera.twist_covariance, kPublishedRounding));
  }

  FuzzInput& input_;
  Overlay overlay_;
  const Parameters parameters_;
  FrameProcessor processor_;
  Shown before_;  ///< the last in order
  double clock_ = 1000, stamp_ = 1000, last_used_ = 0;
  bool reset_ = false, configured_ = false;
};

}  // namespace

void check(FuzzInput input) {
  quietRos();
  if (input.byte() > 224) return checkStamps(input);
  Schedule schedule(input);
  for (int i = 0; i < 12 && !input.empty(); ++i) schedule.step();
}

}  // namespace gms_ransac
