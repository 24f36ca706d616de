// A stream of images without a graph: what the tests of the node's decisions give to FrameProcessor.
#pragma once

#include <string>

#include <cv_bridge/cv_bridge.h>
#include <opencv2/imgproc.hpp>

#include "stream/frame_processor.h"

namespace gms_ransac {

/// A grey image, or depth in metres.
inline sensor_msgs::ImageConstPtr imageMessage(const cv::Mat& image, double stamp) {
  std_msgs::Header header;
  header.stamp = ros::Time(stamp);
  header.frame_id = "camera";
  return cv_bridge::CvImage(header, image.type() == CV_8UC1 ? "mono8" : "32FC1", image).toImageMsg();
}

/// Corners everywhere at VGA, moved by some pixels, 500 at most.
inline cv::Mat cornersMovedBy(int shift) {
  cv::Mat noise(96, 228, CV_8UC1), texture;
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::resize(noise, texture, cv::Size(), 5, 5, cv::INTER_NEAREST);
  return texture(cv::Rect(shift, 0, 640, 480)).clone();
}

/// The same by a sensor, which measures nothing twice: with noise of its own.
inline cv::Mat measured(const cv::Mat& image, uint64_t seed) {
  cv::Mat noise(image.size(), CV_16SC1), seen;
  cv::RNG(seed + 1).fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::add(image, noise, seen, cv::noArray(), CV_8U);
  return seen;
}

/// One camera, of VGA unless it is given.
inline Parameters calibrated(ScaleMode scale = ScaleMode::kUnit,
                             const CameraIntrinsics& camera = {500, 500, 319.5, 239.5, "", {}}) {
  Parameters parameters;
  parameters.scale = scale;
  parameters.camera = camera;
  return parameters;
}

/// A processor with options, whose topics are below `side`.
struct Processor : FrameProcessor {
  explicit Processor(const Parameters& parameters, const ProcessorOptions& options = {}, const std::string& side = "/")
      : FrameProcessor(parameters, side + "image", side + "camera_info") {
    setOptions(options);
  }
  std::shared_ptr<PreparedFrame> prepared(const ImageWithInfo& input) { return prepare(receive(input)).frame; }
  ProcessedFrame ask(const ImageWithInfo& input) { return process(prepare(receive(input))); }
};

/// A stream of images of one camera, as the node processes it.
class ImageStream {
 public:
  ImageStream(ScaleMode scale, const CameraIntrinsics& camera, const ProcessorOptions& options, double fixed_scale = 1,
              double period = 0.04)
      : processor_(withFixedScale(calibrated(scale, camera), fixed_scale), options), period_(period) {}

  ProcessedFrame process(const cv::Mat& grey, const cv::Mat_<float>& depth = {}) {
    ImageWithInfo input;
    input.image = message(grey);
    if (!depth.empty()) input.depth = imageMessage(depth, stamp_);
    return process(input);
  }
  ProcessedFrame process(ImageWithInfo input) {
    input.received = ros::Time(stamp_);
    return processor_.ask(input);
  }
  /// The next image of the stream.
  sensor_msgs::ImageConstPtr message(const cv::Mat& grey) { return imageMessage(grey, stamp_ += period_); }
  /// No image comes for that long, seconds.
  void wait(double seconds) { stamp_ += seconds; }
  double stamp() const { return stamp_; }

 private:
  static Parameters withFixedScale(Parameters parameters, double fixed_scale) {
    parameters.fixed_scale = fixed_scale;
    return parameters;
  }

  Processor processor_;
  double period_, stamp_ = 100;  // seconds
};

}  // namespace gms_ransac
