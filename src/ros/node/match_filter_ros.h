// The match filter in a ROS graph: parameters, inputs, worker and outputs put together. The nodelet and the node are
// shells over this one class.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <ros/node_handle.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include "input/image_with_info.h"
#include "node/calibration_watch.h"
#include "node/mailbox.h"
#include "output/output_options.h"
#include "parameters.h"
#include "throttle.h"

namespace gms_ransac {

class Diagnostics;
class FrameProcessor;
class GraphWatch;
class ImageInput;
class MotionPriors;
class Outputs;
class Reconfigure;
struct PreparedFrame;
struct ProcessedFrame;
struct RuntimeOptions;

class MatchFilterRos {
 public:
  /// Inputs are relative to `nh`, outputs and parameters to `pnh`. Throws std::invalid_argument with a sentence that
  /// names the parameter when one is wrong.
  MatchFilterRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);
  ~MatchFilterRos();

 private:
  /// Throws std::invalid_argument and changes nothing where they contradict each other.
  void setOptions(const RuntimeOptions& options);
  /// Subscribes to the images while an output has a subscriber.
  void updateSubscription();
  void onImage(const ImageWithInfo& input);
  bool reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  /// The worker: images from the mailbox to outputs; with a second thread only up to the extraction.
  void work();
  void processPrepared();
  void process(const ImageWithInfo& input);
  /// Compares and publishes. Skips images that ~features does not need while no other output has a subscriber.
  void answer(std::unique_ptr<PreparedFrame> frame);
  void publish(const ProcessedFrame& processed, const OutputOptions& options);
  OutputOptions outputOptions();
  /// Runs what a callback or a worker does; an exception becomes a warning.
  template <typename Work>
  void guard(const Work& work);
  void watchInput();
  /// Reports to diagnostics why the calibration may be wrong, if there is a reason.
  void watchCalibration(const ProcessedFrame& processed);

  ros::NodeHandle nh_, pnh_;
  const Parameters parameters_;
  Throttle throttle_;

  std::mutex options_mutex_;
  OutputOptions output_options_;

  std::atomic<uint32_t> received_{0}, dropped_{0};
  // Used by the publishing thread only.
  uint32_t processed_ = 0, passed_over_ = 0, resets_ = 0;
  CalibrationWatch calibration_watch_;

  std::mutex subscription_mutex_;
  std::atomic<bool> closing_{false}, paused_{false};
  // Members are destroyed in reverse order. An image may be freed by code of an image_transport plugin that the input
  // unloads, so every member that holds images is declared after the input.
  std::shared_ptr<MotionPriors> priors_;  ///< null: no other sensor is used
  std::unique_ptr<ImageInput> input_;
  Mailbox<ImageWithInfo> mailbox_;
  Mailbox<std::unique_ptr<PreparedFrame>> prepared_;  ///< between the two threads, if there are two
  std::unique_ptr<FrameProcessor> processor_;
  std::unique_ptr<Outputs> outputs_;
  std::unique_ptr<Reconfigure> reconfigure_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::unique_ptr<GraphWatch> graph_watch_;
  ros::ServiceServer reset_service_, pause_service_;
  ros::WallTimer watch_timer_;
  int silent_seconds_ = 0;
  ros::Time last_clock_;           ///< when `watchInput` ran
  std::string subscribe_problem_;  ///< guarded by subscription_mutex_
  std::thread worker_, second_worker_;
};

}  // namespace gms_ransac
