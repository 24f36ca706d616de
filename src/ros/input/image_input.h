// Subscribes to the images and what belongs to them, and hands over what belongs together.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include "input/image_with_info.h"
#include "input/topics.h"
#include "input/waiting_images.h"
#include "parameters.h"
#include "throttle.h"

namespace gms_ransac {

class MotionPriors;

class ImageInput {
 public:
  using Callback = std::function<void(const ImageWithInfo&)>;

  /// `nh`: the inputs are relative to it; `pnh`: that of ~mask, and where ~image_transport and its options are looked
  /// up. `priors`: what images wait for, started and stopped with them; null: nothing.
  ImageInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters, Callback callback,
             std::shared_ptr<MotionPriors> priors);

  /// Throws std::invalid_argument with a sentence when ~image_transport, or ~depth_image_transport where depth is
  /// read, is not installed.
  void checkTransports() const;
  /// Throws image_transport::TransportLoadException when ~image_transport names a transport that is not installed.
  void start();
  void stop();
  bool started() const { return started_; }

  /// The current one of a pair; what is subscribed to lies below it when ~image_transport is not raw.
  std::string imageTopic() const { return topic(parameters_.input == InputKind::kPair ? 1 : 0); }
  /// Everything subscribed to whose type is known.
  std::vector<InputTopic> inputs() const;
  std::string infoTopic() const { return nh_.resolveName(infoName()); }
  /// Topics of the right camera, with ~input stereo.
  std::string rightTopic() const { return nh_.resolveName("right/image"); }
  std::string rightInfoTopic() const { return nh_.resolveName("right/camera_info"); }
  /// Images dropped because no camera_info had their stamp; none: their stamps need not be equal.
  std::optional<int> unpaired();
  /// Returns which topic several nodes publish, so that their messages mix, and the remedy; empty: none.
  std::string mixedTopic() const;
  /// Returns what has not arrived since the last call, and the remedy; empty while images come.
  std::string waitingFor(const Topics& published);

 private:
  struct ImageStream {
    const char *name, *transport_parameter;
    std::string transport;
  };

  static std::vector<ImageStream> streamsOf(const Parameters& parameters);
  WaitingOptions waitingOptions() const;
  bool exactInfo() const {
    return !parameters_.camera.calibrated() && parameters_.camera_info_sync == CameraInfoSync::kExact;
  }
  const char* infoName() const { return parameters_.input == InputKind::kStereo ? "left/camera_info" : "camera_info"; }
  std::string topic(size_t stream) const { return nh_.resolveName(streams_[stream].name); }
  /// `add` is called, with mutex_ held, for each image of the stream.
  void subscribe(size_t stream, const std::function<void(const sensor_msgs::ImageConstPtr&)>& add);
  void subscribeKeypoints();
  /// With mutex_ held.
  void add(const sensor_msgs::ImageConstPtr& image, const KeypointsConstPtr& keypoints = nullptr);
  /// Makes a change, with mutex_ held, and hands over the images that need wait no longer.
  void settle(const std::function<void()>& change);
  /// Called by the timer while images wait for partners, other sensors or tf.
  void lookAgain();
  /// Lets the timer run, or rest; with mutex_ held.
  void keepLooking(bool looking);

  ros::NodeHandle nh_, pnh_;
  image_transport::ImageTransport transport_;
  const Parameters parameters_;
  const std::vector<ImageStream> streams_;  ///< the second: depth, the current one of a pair, or the right camera's
  const Callback callback_;
  const std::shared_ptr<MotionPriors> priors_;
  bool started_ = false;
  std::vector<ros::Subscriber> subscribers_;
  std::vector<image_transport::Subscriber> image_subscribers_;  ///< of each stream; empty if it is compressed
  ros::SteadyTimer look_timer_;
  Throttle throttle_;

  std::mutex mutex_;            ///< guards what follows
  WaitingImages waiting_;       ///< after the subscribers: a transport's plugin may have to free what it holds
  bool looking_ = false;        ///< look_timer_ runs
  int images_ = 0, infos_ = 0;  ///< since the last call of waitingFor
  int matched_ = 0;             ///< as WaitingImages::matched() was then
  bool is_published_ = false;   ///< the first stream had a publisher then
  ros::Time last_image_stamp_, last_info_stamp_;
};

}  // namespace gms_ransac
