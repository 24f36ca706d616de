#include "node/match_filter_ros.h"

#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <variant>
#include <vector>

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <opencv2/core/version.hpp>

#include "guard.h"
#include "input/image_input.h"
#include "node/diagnostics.h"
#include "node/graph_watch.h"
#include "node/mailbox.h"
#include "node/reconfigure.h"
#include "output/outputs.h"
#include "priors/motion_priors.h"
#include "stream/frame_processor.h"

namespace gms_ransac {

namespace {

constexpr double kWatchPeriod = 1;  // seconds
constexpr int kSilentPeriods = 5;   // without an image before the log names the silent topic
constexpr int kPairsBeforeMaskReport = 30;
constexpr double kSilenceRepeats = 30;  // seconds after which it names it again

/// As the end of a sentence.
std::string whenSubscribed(bool always, const OutputOptions& options) {
  if (always) return " always (~always_subscribe)";
  if (options.publish_relative_tf) return " while it broadcasts a transform (~publish_relative_tf)";
  if (options.publish_odom_tf) return " while it broadcasts a transform (~publish_odom_tf)";
  return " only while an output has a subscriber";
}

/// Warns of simulated time without a clock, which a replay leaves behind for a live camera; empty: no problem.
std::string clockProblem() {
  if (!ros::Time::isSimTime() || !ros::Time::now().isZero()) return std::string();
  return "/use_sim_time is true and no /clock has come, so latency and lookups in tf are wrong; for a live camera "
         "`rosparam set use_sim_time false` and start all nodes again";
}

void refuseOutputAsInput(const std::vector<InputTopic>& inputs, const std::string& output, const std::string& remedy) {
  for (const InputTopic& input : inputs) {
    if (input.topic != output) continue;
    throw std::invalid_argument("input '" + input.name + "' is remapped to " + output +
                                ", an output of this node; remap it to the topic of " + remedy);
  }
}

/// An image between its two threads.
using Unanswered = std::variant<Received, Prepared>;

class MatchFilterRos {
 public:
  MatchFilterRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
      : nh_(nh),
        pnh_(pnh),
        parameters_(readParameters(pnh)),
        throttle_(parameters_.name),
        silence_(parameters_.name, kSilenceRepeats),
        mailbox_(parameters_.drop_frames ? 1 : static_cast<size_t>(parameters_.queue_size)),
        unanswered_(1),
        graph_watch_(parameters_.name) {
    const RuntimeOptions start = readRuntimeOptions(pnh_, parameters_);
    const std::string settings = settingsText(pnh_);  // before rounded values are written back for reconfiguration
    for (const std::string& sentence : parametersWithoutEffect(pnh_, parameters_)) {
      ROS_WARN_STREAM(parameters_.name << ": parameter " << sentence);
    }
    priors_ = MotionPriors::make(nh_, parameters_);
    input_ = std::make_unique<ImageInput>(
        nh_, pnh_, parameters_, [this](const ImageWithInfo& input) { guard([&] { onImage(input); }); }, priors_);
    refuseOutputAsInput(input_->inputs(), Outputs::overlayTopic(pnh_), "a camera");
    refuseOutputAsInput(input_->inputs(), pnh_.resolveName("keypoints"), "your detector");
    input_->checkTransports();
    processor_ = std::make_unique<FrameProcessor>(parameters_, input_->imageTopic(), input_->infoTopic(), priors_,
                                                  input_->rightTopic(), input_->rightInfoTopic());

    processor_->setOptions(start.processor);
    reconfigure_ =
        serveChanges(pnh_, parameters_.name, start, [this](const RuntimeOptions& options) { setOptions(options); });

    {
      // A listener may connect before `outputs_` is assigned.
      std::lock_guard<std::mutex> lock(subscription_mutex_);
      outputs_ = std::make_unique<Outputs>(nh_, pnh_, parameters_, [this] { guard([&] { updateSubscription(); }); });
    }
    ros::NodeHandle watch(nh_);
    watch.setCallbackQueue(&watch_queue_);
    diagnostics_ = std::make_unique<Diagnostics>(watch, pnh_, parameters_);
    ROS_INFO_STREAM(parameters_.name << ": " << settings << "; all other parameters have their defaults; OpenCV "
                                     << CV_VERSION << "; subscribes to " << input_->imageTopic()
                                     << whenSubscribed(parameters_.always_subscribe, start.outputs));
    if (parameters_.input == InputKind::kKeypoints) {
      ROS_INFO_STREAM(
          parameters_.name << ": ~input keypoints brings no pixels, so ~features and ~stereo_features, which "
                              "follow points in them, are not published, and ~match_image is grey");
    }
    updateSubscription();
    reset_service_ = pnh_.advertiseService("reset", &MatchFilterRos::reset, this);
    pause_service_ = pnh_.advertiseService("pause", &MatchFilterRos::pause, this);
    watch_timer_ = watch.createWallTimer(ros::WallDuration(kWatchPeriod), [this](const ros::WallTimerEvent& /*event*/) {
      guard([&] { watchInput(); });
    });
    watch_spinner_.start();
    // Last: if the constructor threw after this, no code would join them.
    worker_ = std::thread([this] { work(); });
    if (parameters_.threads > 1) second_worker_ = std::thread([this] { processPrepared(); });
  }

  ~MatchFilterRos() {
    closing_ = true;
    watch_spinner_.stop();
    reset_service_.shutdown();
    pause_service_.shutdown();
    reconfigure_.reset();
    {
      std::lock_guard<std::mutex> lock(subscription_mutex_);
      input_->stop();
    }
    mailbox_.close();
    unanswered_.close();
    for (std::thread* thread : {&worker_, &second_worker_}) {
      if (thread->joinable()) thread->join();
    }
  }

 private:
  /// Throws std::invalid_argument and changes nothing where they contradict each other.
  void setOptions(const RuntimeOptions& options) {
    processor_->setOptions(options.processor);
    {
      std::lock_guard<std::mutex> lock(options_mutex_);
      output_options_ = options.outputs;
    }
    updateSubscription();
  }

  /// Subscribes to the images while an output has a subscriber.
  void updateSubscription() {
    std::lock_guard<std::mutex> lock(subscription_mutex_);
    if (!outputs_ || closing_) return;
    const OutputOptions options = outputOptions();
    const bool transforms = options.publish_relative_tf || options.publish_odom_tf;
    const bool wanted = !paused_ && (parameters_.always_subscribe || transforms || outputs_->listeners() > 0);
    if (wanted == input_->started()) return;
    if (!wanted) {
      input_->stop();
      // Later images have nothing in common with the earlier ones.
      dropped_ += static_cast<uint32_t>(mailbox_.clear());
      processor_->requestReset(Reset::kUnsubscribed);
      return;
    }
    try {
      input_->start();
      subscribe_problem_.clear();
    } catch (const std::exception& error) {
      input_->stop();
      subscribe_problem_ = "cannot subscribe to " + input_->imageTopic() + " with ~image_transport '" +
                           parameters_.image_transport + "': " + error.what();
      ROS_ERROR_STREAM(parameters_.name << ": " << subscribe_problem_);
    }
  }

  void onImage(const ImageWithInfo& input) {
    ++received_;
    const int dropped = mailbox_.push(input);
    dropped_ += static_cast<uint32_t>(dropped);
    if (dropped == 0 || parameters_.drop_frames) return;
    throttle_.warn("backlog", "images of " + input_->imageTopic() +
                                  " come faster than they are processed: " + std::to_string(parameters_.queue_size) +
                                  " wait, the oldest is dropped although ~drop_frames is false; lower the replay rate "
                                  "or raise ~queue_size");
  }

  bool reset(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
    dropped_ += static_cast<uint32_t>(mailbox_.clear());
    processor_->requestReset();
    response.success = true;
    response.message = "the next image is a new reference";
    return true;
  }

  bool pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
    paused_ = request.data != 0;
    updateSubscription();
    response.success = true;
    response.message = paused_ ? "paused: not subscribed to " + input_->imageTopic() : "running";
    return true;
  }

  /// The worker: images from the mailbox to outputs; with a second thread only up to the extraction.
  void work() {
    ImageWithInfo input;
    while (mailbox_.pop(input)) {
      guard([&] { process(input); });
      input = ImageWithInfo();
    }
  }

  void processPrepared() {
    Unanswered image;
    while (unanswered_.pop(image)) {
      guard([&] { answer(std::move(image)); });
    }
  }

  void process(const ImageWithInfo& input) {
    Received received = processor_->receive(input, outputs_->wanted(outputOptions()));
    // Features alone do not need every image, so their extraction waits until it is known whether they need this one.
    Unanswered image = received.image.wanted.features_alone ? Unanswered(std::move(received))
                                                            : processor_->prepare(std::move(received));
    if (parameters_.threads > 1) {
      unanswered_.pushWhenEmpty(std::move(image));
    } else {
      answer(std::move(image));
    }
  }

  /// Compares and publishes. Skips images that ~features does not need while no other output has a subscriber.
  void answer(Unanswered image) {
    const OutputOptions options = outputOptions();
    if (auto* received = std::get_if<Received>(&image)) {
      if (outputs_->skips(*received, options)) {
        ++passed_over_;
        return;
      }
      image = processor_->prepare(std::move(*received), outputs_->needRightKeypoints());
    }
    const ProcessedFrame processed = processor_->process(std::get<Prepared>(image));
    const std_msgs::Header& header = processed.current->image.header;
    if (const auto set = outputs_->popSetPose(header)) processor_->setPlace(set->pose, set->pose_covariance);
    publish(processed, options);
  }

  /// Logs once what the stream has shown of the shutter.
  void reportShutter(const MatchStats& stats) {
    if (stats.shutter == Shutter::kUnknown || stats.shutter == last_shutter_) return;
    last_shutter_ = stats.shutter;
    const std::string kind = stats.shutter == Shutter::kRolling ? "rolls" : "is global";
    ROS_INFO("%s: the shutter %s: %.1f ms from the first row to the last, standard deviation %.1f ms",
             parameters_.name.c_str(), kind.c_str(), 1e3 * static_cast<double>(stats.shutter_readout),
             1e3 * static_cast<double>(stats.shutter_readout_sigma));
  }
  /// Logs once what the calibration of two cameras or of a depth camera has left, if it matters.
  void reportSensor(const ProcessedFrame& processed) {
    if (sensor_reported_) return;
    const bool depth_is_off = processed.offset && processed.offset->isOff();
    sensor_reported_ = depth_is_off || (processed.rig && processed.rig->isOff());
    if (!sensor_reported_) return;
    if (depth_is_off) {
      constexpr double kDepth = 2;
      const double error = processed.offset->mean();
      ROS_INFO(
          "%s: the depth camera makes a depth of %.0f m %.0f mm too %s, others as the square of the depth: lengths are "
          "corrected by it (inverse_depth_error of ~stats); calibrate its depth anew to be rid of it",
          parameters_.name.c_str(), kDepth, 1e3 * kDepth * kDepth * std::abs(error), error > 0 ? "long" : "short");
      return;
    }
    const Eigen::Vector4d error = processed.rig->mean();
    ROS_INFO(
        "%s: the calibration of the two cameras leaves %+.1f px of the disparities, and %+.1f px more where x^2 + "
        "y^2 = 1 (x, y at depth 1): lengths are corrected by it (disparity_error of ~stats); calibrate both anew to "
        "be rid of it",
        parameters_.name.c_str(), error[0], error[3]);
  }

  /// Logs once what the stream has shown to be fixed to the camera, when it has been so for a while.
  void reportMask(const ProcessedFrame& processed) {
    if (!processed.pair) return;
    const LearnedMask& mask = processed.pair->result.mask;
    pairs_with_mask_ = mask.empty() ? 0 : pairs_with_mask_ + 1;
    if (pairs_with_mask_ != kPairsBeforeMaskReport) return;
    ROS_INFO(
        "%s: %.0f %% of the view is fixed to the camera (an arm, a bonnet, text, dust) and left out; save "
        "~learned_mask as ~mask to know it from the start",
        parameters_.name.c_str(), 100 * mask.share());
  }

  void publish(const ProcessedFrame& processed, const OutputOptions& options) {
    ++processed_;
    if (processed.continuity != Continuity::kContinuous) ++resets_;
    if (processed.status == MatchStats::BAD_IMAGE) throttle_.warn("bad image", processed.text);
    const std::string& mask_problem = processed.current->mask_problem;
    if (!mask_problem.empty()) throttle_.warn("mask", "an image is answered without a mask: " + mask_problem);
    if (processed.current->image.reset != Reset::kNone) {
      throttle_.info("wanted reset", processed.text);
    } else if (processed.continuity != Continuity::kContinuous) {
      throttle_.warn("reset", processed.text);
    }
    // `dropped_` is read first: an image is counted as received before it can be counted as dropped.
    const uint32_t late = dropped_, received = received_;
    const auto unpaired = static_cast<uint32_t>(input_->unpaired().value_or(0));
    const FrameCounters counters = {received + unpaired, processed_, passed_over_, late + unpaired, resets_};
    const MatchStatsConstPtr stats = outputs_->publish(processed, counters, options);
    const auto& camera = processed.current->image.camera;
    const bool uncalibrated = camera && !camera->problem.empty();
    diagnostics_->add(*stats, unpaired, outputs_->problem(), uncalibrated ? camera->problem : processed.doubt);
    if (processed.doubt != last_doubt_ && !processed.doubt.empty()) throttle_.warn("doubt", processed.doubt);
    last_doubt_ = processed.doubt;
    reportShutter(*stats);
    reportSensor(processed);
    reportMask(processed);
  }

  OutputOptions outputOptions() {
    std::lock_guard<std::mutex> lock(options_mutex_);
    return output_options_;
  }

  /// Runs what a callback or a worker does; an exception becomes a warning.
  template <typename Work>
  void guard(const Work& work) {
    guarded(work, [this](const std::string& what) { throttle_.warn("unexpected", what); });
  }
  void watchInput() {
    graph_watch_.look();
    if (graph_watch_.answered()) outputs_->watch(graph_watch_.problem().empty());
    const Topics& published = graph_watch_.topics();
    NodeReport report;
    report.error = wrongTypes(input_->inputs(), published);
    {
      std::lock_guard<std::mutex> lock(subscription_mutex_);
      report.waiting = input_->waitingFor(published);
      report.mixed = input_->mixedTopic();
      if (report.error.empty()) report.error = subscribe_problem_;
      if (!input_->started()) report.idle = paused_ ? "paused by ~pause" : "not subscribed: no output has a subscriber";
    }
    // A bag that is paused or has ended stops the clock, and its images with it: no reason to warn.
    const ros::Time clock = ros::Time::now();
    if (ros::Time::isSimTime() && !clock.isZero() && clock == last_clock_ && report.idle.empty()) {
      report.idle = "/clock stands still: the bag is paused or has ended";
    }
    last_clock_ = clock;
    silent_seconds_ = report.waiting.empty() || !report.idle.empty() ? 0 : silent_seconds_ + 1;
    if (silent_seconds_ < kSilentPeriods || !report.error.empty()) report.waiting.clear();
    if (!report.waiting.empty()) silence_.warn("waiting", report.waiting);
    if (!report.mixed.empty()) throttle_.warn("mixed", report.mixed);
    if (!report.error.empty()) throttle_.error("input", report.error);
    report.unpaired = input_->unpaired();
    if (priors_) report.priors = priors_->report();
    for (const auto& [key, sentence] : report.priors.found) throttle_.infoOnce(key, sentence);
    const std::string &registration = graph_watch_.problem(), no_clock = received_ > 0 ? clockProblem() : std::string();
    if (!no_clock.empty()) throttle_.warn("clock", no_clock);
    report.graph = !registration.empty() ? registration : !no_clock.empty() ? no_clock : outputs_->refusal();
    diagnostics_->update(report);
  }

  ros::NodeHandle nh_, pnh_;
  const Parameters parameters_;
  Throttle throttle_, silence_;

  std::mutex options_mutex_;
  OutputOptions output_options_;

  std::atomic<uint32_t> received_{0}, dropped_{0};
  // Used by the publishing thread only.
  uint32_t processed_ = 0, passed_over_ = 0, resets_ = 0;
  std::string last_doubt_;
  uint8_t last_shutter_ = Shutter::kUnknown;
  bool sensor_reported_ = false;
  int pairs_with_mask_ = 0;  ///< in a row

  std::mutex subscription_mutex_;
  std::atomic<bool> closing_{false}, paused_{false};
  // Members are destroyed in reverse order. An image may be freed by code of an image_transport plugin that the input
  // unloads, so every member that holds images is declared after the input.
  std::shared_ptr<MotionPriors> priors_;  ///< null: no other sensor is used
  std::unique_ptr<ImageInput> input_;
  Mailbox<ImageWithInfo> mailbox_;
  Mailbox<Unanswered> unanswered_;  ///< between the two threads, if there are two
  std::unique_ptr<FrameProcessor> processor_;
  std::unique_ptr<Outputs> outputs_;
  std::shared_ptr<void> reconfigure_;
  ros::CallbackQueue watch_queue_;  ///< with a thread of its own: what happens once a second must not delay images
  std::unique_ptr<Diagnostics> diagnostics_;
  GraphWatch graph_watch_;
  ros::ServiceServer reset_service_, pause_service_;
  ros::WallTimer watch_timer_;
  ros::AsyncSpinner watch_spinner_{1, &watch_queue_};
  int silent_seconds_ = 0;
  ros::Time last_clock_;           ///< when `watchInput` ran
  std::string subscribe_problem_;  ///< guarded by subscription_mutex_
  std::thread worker_, second_worker_;
};

}  // namespace

std::shared_ptr<void> runMatchFilter(const ros::NodeHandle& nh, const ros::NodeHandle& pnh) {
  return std::make_shared<MatchFilterRos>(nh, pnh);
}

}  // namespace gms_ransac
