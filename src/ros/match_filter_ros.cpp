#include "match_filter_ros.h"

#include <exception>
#include <stdexcept>

#include <opencv2/core/version.hpp>

namespace gms_ransac {

namespace {

constexpr double kInputCheckPeriod = 5;  // seconds without an image before the log says which topic is silent
// Every frame is kept when none may be dropped; a queue this long means that replay outruns the computer.
constexpr int kLongQueue = 200;

}  // namespace

MatchFilterRos::MatchFilterRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& name)
    : nh_(nh), pnh_(pnh), name_(name), parameters_(Parameters::read(pnh)), mailbox_(parameters_.drop_frames) {
  for (const std::string& unknown : unknownParameters(pnh_)) {
    ROS_WARN_STREAM(name_ << ": parameter " << pnh_.resolveName(unknown) << " is set but not known; misspelt?");
  }
  checkConfigOnServer(pnh_);
  input_ = std::make_unique<ImageInput>(nh_, pnh_, parameters_, [this](const ImageWithInfo& input) { onImage(input); });
  processor_ = std::make_unique<FrameProcessor>(parameters_, input_->imageTopic(), input_->infoTopic());

  reconfigure_server_ = std::make_unique<dynamic_reconfigure::Server<MatchFilterConfig>>(reconfigure_mutex_, pnh_);
  {
    // The values the node starts with are refused here, with a sentence; dynamic_reconfigure would only log them.
    MatchFilterConfig config = MatchFilterConfig::__getDefault__();
    config.__fromServer__(pnh_);
    processor_->setOptions(coreOptions(config), config.max_frame_gap);
    config_ = config;
  }
  // Deadlock ahead: the server holds its mutex while it calls back, so nothing here may wait for it with another held.
  reconfigure_server_->setCallback([this](MatchFilterConfig& config, uint32_t level) { reconfigure(config, level); });

  {
    // A listener may connect before `outputs_` is assigned.
    std::lock_guard<std::mutex> lock(subscription_mutex_);
    outputs_ = std::make_unique<Outputs>(nh_, pnh_, [this] { updateSubscription(); });
  }
  worker_ = std::thread([this] { work(); });
  ROS_INFO_STREAM(name_ << ": method " << config_.method << ", model " << config_.model << ", OpenCV " << CV_VERSION
                        << "; subscribes to " << input_->imageTopic()
                        << (parameters_.always_subscribe
                                ? " always (~always_subscribe)"
                                : " only while someone listens or ~publish_relative_tf is on"));
  updateSubscription();
  input_timer_ = nh_.createWallTimer(ros::WallDuration(kInputCheckPeriod), &MatchFilterRos::checkInput, this);
}

MatchFilterRos::~MatchFilterRos() {
  closing_ = true;
  input_timer_.stop();
  reconfigure_server_.reset();
  {
    std::lock_guard<std::mutex> lock(subscription_mutex_);
    input_->stop();
  }
  mailbox_.close();
  if (worker_.joinable()) worker_.join();
}

void MatchFilterRos::reconfigure(MatchFilterConfig& config, uint32_t /*level*/) {
  try {
    processor_->setOptions(coreOptions(config), config.max_frame_gap);
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(name_ << ": change refused, the old parameters stay: " << error.what());
    std::lock_guard<std::mutex> lock(options_mutex_);
    config = config_;
    return;
  }
  {
    std::lock_guard<std::mutex> lock(options_mutex_);
    config_ = config;
    output_options_.publish_rejected = config.publish_rejected;
    output_options_.publish_relative_tf = config.publish_relative_tf;
    output_options_.sigma_floor = {config.translation_sigma_floor, config.rotation_sigma_floor};
  }
  updateSubscription();
}

void MatchFilterRos::updateSubscription() {
  std::lock_guard<std::mutex> lock(subscription_mutex_);
  if (!outputs_ || closing_) return;
  bool transforms;
  {
    std::lock_guard<std::mutex> options_lock(options_mutex_);
    transforms = output_options_.publish_relative_tf;
  }
  const bool wanted = parameters_.always_subscribe || transforms || outputs_->listeners() > 0;
  if (wanted == input_->started()) return;
  if (!wanted) {
    input_->stop();
    // What comes when someone listens again has nothing to do with what came before.
    dropped_ += static_cast<uint32_t>(mailbox_.clear());
    processor_->requestReset();
    return;
  }
  try {
    input_->start();
  } catch (const std::exception& error) {
    input_->stop();
    ROS_ERROR_STREAM(name_ << ": cannot subscribe to " << input_->imageTopic() << " with ~image_transport '"
                           << parameters_.image_transport << "': " << error.what());
  }
}

void MatchFilterRos::onImage(const ImageWithInfo& input) {
  ++received_;
  dropped_ += static_cast<uint32_t>(mailbox_.push(input));
  if (!parameters_.drop_frames && mailbox_.size() > kLongQueue) {
    ROS_WARN_STREAM_THROTTLE(10, name_ << ": " << mailbox_.size() << " images of " << input_->imageTopic()
                                       << " wait to be processed and none may be dropped; lower the replay rate or "
                                          "set ~drop_frames");
  }
}

void MatchFilterRos::work() {
  ImageWithInfo input;
  while (mailbox_.pop(input)) {
    try {
      handle(input);
    } catch (const std::exception& error) {
      // Nothing is known to throw here; but a nodelet must never take its manager down.
      throttle_.warn("unexpected", name_ + ": image not answered: " + error.what());
    }
    input = ImageWithInfo();
  }
}

void MatchFilterRos::handle(const ImageWithInfo& input) {
  const Answer answer = processor_->answer(processor_->prepare(input));
  ++processed_;
  if (answer.was_reset) ++resets_;
  if (answer.status == Status::kBadImage) throttle_.warn("bad image", name_ + ": " + answer.text);
  if (answer.was_reset) throttle_.warn("reset", name_ + ": " + answer.text);
  OutputOptions options;
  {
    std::lock_guard<std::mutex> lock(options_mutex_);
    options = output_options_;
  }
  outputs_->publish(answer, {received_, processed_, dropped_, resets_}, options);
}

void MatchFilterRos::checkInput(const ros::WallTimerEvent& /*event*/) {
  std::string waiting;
  {
    std::lock_guard<std::mutex> lock(subscription_mutex_);
    waiting = input_->waitingFor();
  }
  if (!waiting.empty()) ROS_WARN_STREAM_THROTTLE(30, name_ << ": " << waiting);
}

}  // namespace gms_ransac
