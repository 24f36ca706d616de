// A schedule of images, resets, clock jumps and reconfigurations against the node's frame processor: one answer for
// each image, every one of them sound and fit to publish.
#include <cmath>

#include "fuzz_answers.h"
#include "fuzz_messages.h"
#include "methods/method.h"
#include "output/message_conversion.h"
#include "output/overlay.h"
#include "output/point_messages.h"

namespace gms_ransac {
namespace {

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

  sensor_msgs::ImagePtr nextImage() {
    static const std::vector<std::string> kEncodings = {"mono8", "bgr8", "mono16", "yuv422", "bayer_rggb8"};
    const uint8_t kind = input_.byte();
    if (kind > 224) return fuzzedImage(input_, kEncodings, 160);
    const sensor_msgs::ImagePtr image = wallView(input_.byte(), input_.between(0, 3) * 8);
    if (kind > 208) image->data.resize(image->data.size() / 2);
    return image;
  }

  void image() {
    ImageWithInfo with_info;
    const sensor_msgs::ImagePtr image = nextImage();
    stamp_ += input_.within(0, 0.2);
    clock_ += 0.1;
    image->header.stamp = ros::Time(stamp_);
    image->header.frame_id = input_.byte() > 240 ? input_.text(20) : "camera";
    with_info.image = image;
    if (input_.byte() > 128) with_info.camera_info = fuzzedCameraInfo(input_, kWallWidth, kWallHeight);
    if (input_.byte() > 200) with_info.mask = fuzzedImage(input_, std::vector<std::string>{"mono8"}, 160);
    if (parameters_.scale == ScaleMode::kDepth && input_.flag()) with_info.depth = depth();
    if (parameters_.input == InputKind::kPair) with_info.reference = nextImage();
    with_info.received = ros::Time(clock_);
    const Prepared prepared = processor_.prepare(processor_.receive(with_info));
    demand(prepared.frame != nullptr, "an image is prepared");
    check(processor_.process(prepared), *image);
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
  double clock_ = 1000, stamp_ = 1000, last_used_ = 0;
  bool reset_ = false, configured_ = false;
};

}  // namespace

void check(FuzzInput input) {
  quietRos();
  Schedule schedule(input);
  for (int i = 0; i < 12 && !input.empty(); ++i) schedule.step();
}

}  // namespace gms_ransac
