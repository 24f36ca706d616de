#include "node/match_filter_ros.h"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <vector>

#include <opencv2/core/version.hpp>

#include "guard.h"
#include "input/image_input.h"
#include "node/diagnostics.h"
#include "node/master_watch.h"
#include "node/reconfigure.h"
#include "output/outputs.h"
#include "priors/motion_priors.h"
#include "stream/frame_processor.h"

namespace gms_ransac {

namespace {

constexpr double kWatchPeriod = 1;  // seconds
constexpr int kSilentPeriods = 5;   // without an image before the log says which topic is silent

/// As the end of a sentence.
std::string whenSubscribed(bool always, const OutputOptions& options) {
  if (always) return " always (~always_subscribe)";
  if (options.publish_relative_tf) return " while it broadcasts a transform (~publish_relative_tf)";
  if (options.publish_odom_tf) return " while it broadcasts a transform (~publish_odom_tf)";
  return " only while someone listens to an output";
}

/// What a replay leaves behind for a live camera; empty: nothing.
std::string clockProblem() {
  if (!ros::Time::isSimTime() || !ros::Time::now().isZero()) return std::string();
  return "/use_sim_time is true and no /clock has come, so latency and lookups in tf are wrong; for a live camera "
         "`rosparam set use_sim_time false` and start all nodes again";
}

/// Alone the node would wait for itself for ever, as its own listener; beside a camera every image would come twice.
void refuseOwnOutput(const std::vector<std::string>& inputs, const std::string& overlay) {
  if (std::find(inputs.begin(), inputs.end(), overlay) == inputs.end()) return;
  throw std::invalid_argument("the input " + overlay + " is this node's own output; remap it to the topic of a camera");
}

}  // namespace

template <typename Work>
void MatchFilterRos::guard(const Work& work) {
  guarded(work, [this](const std::string& what) { throttle_.warn("unexpected", name_ + ": " + what); });
}

MatchFilterRos::MatchFilterRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& name)
    : nh_(nh),
      pnh_(pnh),
      name_(name),
      parameters_(Parameters::read(pnh, name)),
      mailbox_(parameters_.drop_frames ? 1 : static_cast<size_t>(parameters_.queue_size)),
      prepared_(1) {
  for (const std::string& unknown : unknownParameters(pnh_, parameters_)) {
    ROS_WARN_STREAM(name_ << ": parameter " << pnh_.resolveName(unknown) << " is set but not known; misspelt?");
  }
  priors_ = MotionPriors::make(nh_, parameters_);
  input_ = std::make_unique<ImageInput>(
      nh_, pnh_, parameters_, [this](const ImageWithInfo& input) { guard([&] { onImage(input); }); }, priors_);
  refuseOwnOutput(input_->imageTopics(), Outputs::overlayTopic(pnh_));
  input_->checkTransports();
  processor_ = std::make_unique<FrameProcessor>(parameters_, input_->imageTopic(), input_->infoTopic(), priors_,
                                                input_->rightTopic(), input_->rightInfoTopic());

  reconfigure_ = std::make_unique<Reconfigure>(pnh_, name_, parameters_.threads);
  const RuntimeOptions start = reconfigure_->startOptions();
  processor_->setOptions(start.processor);
  reconfigure_->serve([this](const RuntimeOptions& options) { setOptions(options); });

  {
    // A listener may connect before `outputs_` is assigned.
    std::lock_guard<std::mutex> lock(subscription_mutex_);
    outputs_ = std::make_unique<Outputs>(nh_, pnh_, parameters_, [this] { guard([&] { updateSubscription(); }); });
  }
  if (start.outputs.publish_odom_tf) outputs_->expectOdomTf();
  diagnostics_ = std::make_unique<Diagnostics>(nh_, pnh_, name_);
  master_watch_ = std::make_unique<MasterWatch>(name_);
  ROS_INFO_STREAM(name_ << ": method " << start.processor.core.method << ", model "
                        << toString(start.processor.core.robust.model) << ", OpenCV " << CV_VERSION
                        << "; subscribes to " << input_->imageTopic()
                        << whenSubscribed(parameters_.always_subscribe, start.outputs));
  updateSubscription();
  reset_service_ = pnh_.advertiseService("reset", &MatchFilterRos::reset, this);
  pause_service_ = pnh_.advertiseService("pause", &MatchFilterRos::pause, this);
  watch_timer_ = nh_.createWallTimer(ros::WallDuration(kWatchPeriod),
                                     [this](const ros::WallTimerEvent& /*event*/) { guard([&] { watchInput(); }); });
  // Last: were an exception to leave the constructor, nobody would join them.
  worker_ = std::thread([this] { work(); });
  if (parameters_.threads > 1) second_worker_ = std::thread([this] { processPrepared(); });
}

MatchFilterRos::~MatchFilterRos() {
  closing_ = true;
  watch_timer_.stop();
  reset_service_.shutdown();
  pause_service_.shutdown();
  reconfigure_.reset();
  {
    std::lock_guard<std::mutex> lock(subscription_mutex_);
    input_->stop();
  }
  mailbox_.close();
  prepared_.close();
  for (std::thread* thread : {&worker_, &second_worker_}) {
    if (thread->joinable()) thread->join();
  }
}

void MatchFilterRos::setOptions(const RuntimeOptions& options) {
  processor_->setOptions(options.processor);
  {
    std::lock_guard<std::mutex> lock(options_mutex_);
    output_options_ = options.outputs;
  }
  updateSubscription();
}

void MatchFilterRos::updateSubscription() {
  std::lock_guard<std::mutex> lock(subscription_mutex_);
  if (!outputs_ || closing_) return;
  const OutputOptions options = outputOptions();
  const bool transforms = options.publish_relative_tf || options.publish_odom_tf;
  const bool wanted = !paused_ && (parameters_.always_subscribe || transforms || outputs_->listeners() > 0);
  if (wanted == input_->started()) return;
  if (!wanted) {
    input_->stop();
    // What comes when someone listens again has nothing to do with what came before.
    dropped_ += static_cast<uint32_t>(mailbox_.clear());
    processor_->requestReset(Reset::kUnsubscribed);
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
  const int dropped = mailbox_.push(input);
  dropped_ += static_cast<uint32_t>(dropped);
  if (dropped == 0 || parameters_.drop_frames) return;
  throttle_.warn("backlog", name_ + ": images of " + input_->imageTopic() +
                                " come faster than they are processed: " + std::to_string(parameters_.queue_size) +
                                " wait, the oldest is dropped although ~drop_frames is false; lower the replay rate "
                                "or raise ~queue_size");
}

bool MatchFilterRos::reset(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
  dropped_ += static_cast<uint32_t>(mailbox_.clear());
  processor_->requestReset();
  response.success = true;
  response.message = "the next image is a new reference";
  return true;
}

bool MatchFilterRos::pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  paused_ = request.data != 0;
  updateSubscription();
  response.success = true;
  response.message = paused_ ? "paused: not subscribed to " + input_->imageTopic() : "running";
  return true;
}

void MatchFilterRos::work() {
  ImageWithInfo input;
  while (mailbox_.pop(input)) {
    guard([&] { process(input); });
    input = ImageWithInfo();
  }
}

void MatchFilterRos::process(const ImageWithInfo& input) {
  const bool may_pass = outputs_->featuresSuffice(outputOptions());
  auto frame = processor_->prepare(input, may_pass ? Extraction::kPutOff : Extraction::kNow);
  if (parameters_.threads > 1) {
    prepared_.pushWhenEmpty(std::move(frame));
  } else {
    answer(std::move(frame));
  }
}

void MatchFilterRos::processPrepared() {
  std::unique_ptr<PreparedFrame> frame;
  while (prepared_.pop(frame)) {
    guard([&] { answer(std::move(frame)); });
  }
}

void MatchFilterRos::answer(std::unique_ptr<PreparedFrame> frame) {
  const OutputOptions options = outputOptions();
  if (!frame->extracted && outputs_->passesOver(*frame, options)) {
    ++passed_over_;
    processor_->passOver(std::move(frame));
  } else {
    publish(processor_->process(std::move(frame)), options);
  }
}

OutputOptions MatchFilterRos::outputOptions() {
  std::lock_guard<std::mutex> lock(options_mutex_);
  return output_options_;
}

void MatchFilterRos::publish(const ProcessedFrame& processed, const OutputOptions& options) {
  ++processed_;
  if (processed.continuity != Continuity::kContinuous) ++resets_;
  watchCalibration(processed);
  if (processed.status == MatchStats::BAD_IMAGE) throttle_.warn("bad image", name_ + ": " + processed.text);
  const std::string& mask_problem = processed.current->mask_problem;
  if (!mask_problem.empty()) throttle_.warn("mask", name_ + ": an image is answered without mask: " + mask_problem);
  if (processed.current->reset != Reset::kNone) {
    throttle_.info("wanted reset", name_ + ": " + processed.text);
  } else if (processed.continuity != Continuity::kContinuous) {
    throttle_.warn("reset", name_ + ": " + processed.text);
  }
  // An image is counted as dropped after it was counted as received, so here it is the other way round: else one that
  // comes meanwhile and pushes out another would make more answers than images.
  const uint32_t dropped = dropped_, received = received_;
  const FrameCounters counters = {received, processed_, passed_over_, dropped, resets_};
  diagnostics_->add(*outputs_->publish(processed, counters, options));
}

void MatchFilterRos::watchCalibration(const ProcessedFrame& processed) {
  const auto& camera = processed.current->camera;
  if (!camera) return;
  if (camera != watched_camera_) calibration_watch_.reset();
  watched_camera_ = camera;
  if (processed.poseValid()) calibration_watch_.add(processed.result->robust, camera->camera);
  const std::string doubt = calibration_watch_.doubt();
  if (!doubt.empty()) throttle_.warn("calibration", name_ + ": " + doubt);
  diagnostics_->setCalibrationDoubt(camera->doubt.empty() ? doubt : camera->doubt);
}

void MatchFilterRos::watchInput() {
  std::string waiting;
  bool subscribed;
  {
    std::lock_guard<std::mutex> lock(subscription_mutex_);
    waiting = input_->waitingFor();
    subscribed = input_->started();
  }
  silent_seconds_ = waiting.empty() ? 0 : silent_seconds_ + 1;
  if (silent_seconds_ >= kSilentPeriods) ROS_WARN_STREAM_THROTTLE(30, name_ << ": " << waiting);
  diagnostics_->setInput(silent_seconds_ >= kSilentPeriods ? waiting : std::string(), subscribed, paused_);
  if (const auto unpaired = input_->unpaired()) diagnostics_->setUnpaired(*unpaired);
  if (priors_) diagnostics_->setPriors(priors_->report());
  const std::string registration = master_watch_->problem(), clock = received_ > 0 ? clockProblem() : std::string();
  if (!clock.empty()) throttle_.warn("clock", name_ + ": " + clock);
  diagnostics_->setGraph(registration.empty() ? clock : registration);
  diagnostics_->update();
}

}  // namespace gms_ransac
