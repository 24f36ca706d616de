// Subscribes to the images and their camera_info, and hands over what belongs together.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <image_transport/image_transport.h>
#include <image_transport/subscriber_filter.h>
#include <message_filters/subscriber.h>
#include <message_filters/sync_policies/exact_time.h>
#include <message_filters/synchronizer.h>
#include <ros/node_handle.h>

#include "input/image_pairing.h"
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
  std::string imageTopic() const { return parameters_.input == InputKind::kPair ? secondTopic() : firstTopic(); }
  /// Everything subscribed to whose type is known.
  std::vector<InputTopic> inputs() const;
  std::string infoTopic() const { return nh_.resolveName(infoName()); }
  /// Topics of the right camera, with ~input stereo.
  std::string rightTopic() const { return nh_.resolveName("right/image"); }
  std::string rightInfoTopic() const { return nh_.resolveName("right/camera_info"); }
  /// Images dropped because no camera_info had their stamp; none: their stamps need not be equal.
  std::optional<int> unpaired();
  /// Returns what has not arrived since the last call, and the remedy; empty while images come.
  std::string waitingFor(const Topics& published);

 private:
  static constexpr const char* kNames[][2] = {  ///< by InputKind
      {"image", "depth/image"},
      {"reference/image", "current/image"},
      {"left/image", "right/image"}};
  using ExactPolicy = message_filters::sync_policies::ExactTime<sensor_msgs::Image, sensor_msgs::CameraInfo>;

  void checkTransport(const std::string& parameter, const std::string& transport) const;
  void startExact(uint32_t queue, const image_transport::TransportHints& hints);
  void startTwoImages(uint32_t queue, const image_transport::TransportHints& hints);
  bool twoImages() const { return parameters_.input != InputKind::kStream || parameters_.scale == ScaleMode::kDepth; }
  /// The image, the reference of a pair, the left one of two cameras; and what belongs to it.
  const char* firstName() const { return kNames[static_cast<int>(parameters_.input)][0]; }
  const char* secondName() const { return kNames[static_cast<int>(parameters_.input)][1]; }
  const char* infoName() const { return parameters_.input == InputKind::kStereo ? "left/camera_info" : "camera_info"; }
  std::string firstTopic() const { return nh_.resolveName(firstName()); }
  std::string secondTopic() const { return nh_.resolveName(secondName()); }
  /// The name to hand to image_transport.
  std::string toSubscribe(const std::string& name, const std::string& transport) const;
  bool exactInfo() const { return needsInfo() && parameters_.camera_info_sync == CameraInfoSync::kExact; }
  bool needsInfo() const { return !parameters_.camera.calibrated(); }
  void onImage(const sensor_msgs::ImageConstPtr& image);
  void onInfo(const sensor_msgs::CameraInfoConstPtr& info);
  void onPair(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::CameraInfoConstPtr& info);
  /// One of the two is null.
  void onUnpaired(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::CameraInfoConstPtr& info);
  void onFirst(const sensor_msgs::ImageConstPtr& image);
  void onSecond(const sensor_msgs::ImageConstPtr& image);
  /// Hands over the pairs that are settled. An image without depth goes alone; half of a pair is dropped.
  void deliverPairs();
  std::string nobodyPublishes(const std::string& topic, const char* name, const Topics& published) const;
  std::string whyNoImage(const Topics& published) const;
  std::string whyNoPartner(const Topics& published) const;
  void countImage(const sensor_msgs::ImageConstPtr& image);
  void deliver(ImageWithInfo input);
  /// Makes a change, with mutex_ held, after which images may be settled.
  template <typename Change>
  void settle(const Change& change);
  /// Hands over the images that need wait no longer.
  void deliverSettled();
  /// Called by the timer while images wait for partners, other sensors or tf.
  void lookAgain();
  /// Lets the timer run, or rest; with mutex_ held.
  void keepLooking(bool looking);

  ros::NodeHandle nh_, pnh_;
  image_transport::ImageTransport transport_;
  Parameters parameters_;
  Callback callback_;
  const std::shared_ptr<MotionPriors> priors_;
  bool started_ = false;
  ros::Subscriber mask_subscriber_, right_info_subscriber_;

  // camera_info_sync: latest
  image_transport::Subscriber image_subscriber_;
  ros::Subscriber info_subscriber_;
  // camera_info_sync: exact
  image_transport::SubscriberFilter image_filter_;
  message_filters::Subscriber<sensor_msgs::CameraInfo> info_filter_;
  std::unique_ptr<message_filters::Synchronizer<ExactPolicy>> synchronizer_;
  // input: pair or stereo, or scale: depth
  image_transport::Subscriber second_subscriber_;
  ros::SteadyTimer look_timer_;
  Throttle throttle_;

  std::mutex mutex_;      ///< guards what follows
  ImagePairing pairing_;  ///< after the subscribers: a transport's plugin may have to free what it holds
  WaitingImages waiting_;
  bool looking_ = false;        ///< look_timer_ runs
  int images_ = 0, infos_ = 0;  ///< since the last call of waitingFor
  int complete_ = 0;            ///< delivered since then with all that belongs to them
  int unpaired_ = 0;            ///< since the start
  ros::Time last_image_stamp_, last_info_stamp_;
};

}  // namespace gms_ransac
