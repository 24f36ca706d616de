#include "stream/stream_odometry.h"

#include <time.h>

#include <cv_bridge/cv_bridge.h>
#include <ros/console.h>
#include <boost/make_shared.hpp>

#include "priors/motion_priors.h"
#include "stream/frame_processor.h"
#include "stream/parts_of_the_way.h"

namespace gms_ransac {

namespace {

sensor_msgs::ImageConstPtr messageOf(const cv::Mat& image, double stamp) {
  if (image.empty()) return nullptr;
  std_msgs::Header header;
  header.stamp = ros::Time(stamp);
  header.frame_id = "camera";
  return cv_bridge::CvImage(header, image.type() == CV_8UC1 ? "mono8" : "32FC1", image).toImageMsg();
}

/// The camera_info of a rectified camera that stands so far to the right, metres.
sensor_msgs::CameraInfoConstPtr rectifiedInfo(const CameraIntrinsics& k, double offset, const cv::Size& size) {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = static_cast<uint32_t>(size.width);
  info->height = static_cast<uint32_t>(size.height);
  info->K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
  info->R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info->P = {k.fx, 0, k.cx, -k.fx * offset, 0, k.fy, k.cy, 0, 0, 0, 1, 0};
  return info;
}

Parameters parametersOf(const OdometryOptions& options) {
  Parameters parameters;
  parameters.input = options.right ? InputKind::kStereo : InputKind::kStream;
  parameters.scale = options.right ? ScaleMode::kUnit : options.scale;
  parameters.camera_height = options.camera_height;
  if (!options.right) parameters.camera = options.camera;
  if (options.right) parameters.input_is_rectified = Rectified::kTrue;
  return parameters;
}

/// Reports of the node would stand among the tables of a program; warnings stay.
void leaveOutInformation() {
  if (ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Warn)) {
    ros::console::notifyLoggerLevelsChanged();
  }
}

double processorSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

struct StreamOdometry::Implementation {
  explicit Implementation(const OdometryOptions& given)
      : options(given),
        parameters(parametersOf(given)),
        processor(parameters, "image", "camera_info",
                  parameters.usesSensors() ? std::make_shared<MotionPriors>(parameters) : nullptr) {
    leaveOutInformation();
    ProcessorOptions processing;
    processing.core = options.core;
    processing.systematic_sigma = options.systematic_sigma.value_or(processing.systematic_sigma);
    processor.setOptions(processing);
  }

  const OdometryOptions options;
  const Parameters parameters;
  FrameProcessor processor;
  PartsOfTheWay parts;
  Eigen::Isometry3d last_pose = Eigen::Isometry3d::Identity();
};

StreamOdometry::StreamOdometry(const OdometryOptions& options)
    : implementation_(std::make_unique<Implementation>(options)) {}

StreamOdometry::~StreamOdometry() = default;

OdometryAnswer StreamOdometry::add(const OdometryImages& images) {
  const OdometryOptions& options = implementation_->options;
  ImageWithInfo input;
  input.image = messageOf(images.image, images.stamp);
  input.received = ros::Time(images.stamp);
  input.depth = messageOf(images.depth, images.depth_stamp);
  if (options.right) {
    input.right = messageOf(images.right, images.stamp);
    input.camera_info = rectifiedInfo(options.camera, 0, images.image.size());
    input.right_info = rectifiedInfo(*options.right, options.baseline, images.image.size());
  }
  const double start = processorSeconds();
  FrameProcessor& processor = implementation_->processor;
  const ProcessedFrame processed = processor.process(processor.prepare(processor.receive(input)));
  OdometryAnswer answer;
  answer.seconds = processorSeconds() - start;
  answer.text = processed.text;
  answer.metric = processed.metric_scale;
  answer.known = processed.place.has_value();
  if (answer.known) {
    const OdometryEstimate estimate = publishedOf(implementation_->parameters, *processed.place, processed);
    implementation_->last_pose = estimate.pose;
    answer.covariance = estimate.pose_covariance;
    if (processed.pair) answer.twist = OdometryTwist{estimate.twist, estimate.twist_covariance};
  }
  answer.pose = implementation_->last_pose;
  answer.parts = implementation_->parts.add(implementation_->parameters, processed);
  if (processed.poseValid()) {
    answer.reference_stamp = processed.pair->reference->stamp();
    answer.pair = processed.pose;
  }
  return answer;
}

}  // namespace gms_ransac
