#include "input/image_input.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <boost/make_shared.hpp>

#include "input/compressed_image.h"
#include "priors/motion_priors.h"

namespace gms_ransac {

namespace {

// Colour and depth of one moment: half the period of a 30 Hz camera and some jitter.
constexpr double kNear = 0.025;  // seconds
// How long an image waits for its depth, by the wall clock; registering and decompressing depth takes several frames.
// And for the first camera_info: connecting to its publisher takes some milliseconds, on a busy machine hundreds.
constexpr double kPatience = 1;
// Seconds between two looks at images that wait. Looking always would be a hundredth of the node's processor time, so
// the timer rests while none does: it looks once an hour then. To rest it is not stopped, which would wait for its own
// callback.
constexpr double kLookPeriod = 0.1, kRest = 3600;

/// JPEG and PNG need no plugin: see compressed_image.h.
const std::string kCompressed = "compressed";

/// Advice on the package that contains a transport.
std::string whereToGet(const std::string& transport) {
  std::string package;
  if (transport == "theora") package = transport;
  if (transport == "compressedDepth") package = "compressed-depth";
  if (package.empty()) return "check the spelling, or install the package that brings it";
  return "'" + transport + "' comes with the package ros-noetic-" + package +
         "-image-transport (where there is none, build image_transport_plugins)";
}

}  // namespace

ImageInput::ImageInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters,
                       Callback callback, std::shared_ptr<MotionPriors> priors)
    : nh_(nh),
      pnh_(pnh),
      transport_(nh),
      parameters_(parameters),
      streams_(streamsOf(parameters)),
      callback_(std::move(callback)),
      priors_(std::move(priors)),
      throttle_(parameters.name),
      waiting_(waitingOptions()) {}

std::vector<ImageInput::ImageStream> ImageInput::streamsOf(const Parameters& parameters) {
  const auto stream = [&](const char* name) -> ImageStream {
    return {name, "image_transport", parameters.image_transport};
  };
  if (parameters.input == InputKind::kPair) return {stream("reference/image"), stream("current/image")};
  if (parameters.input == InputKind::kStereo) return {stream("left/image"), stream("right/image")};
  if (parameters.input == InputKind::kKeypoints) return {{"keypoints", "image_transport", "raw"}};
  if (parameters.scale != ScaleMode::kDepth) return {stream("image")};
  // Depth is never sent through the transport of the images: lossy ones spoil it.
  return {stream("image"), {"depth/image", "depth_image_transport", parameters.depth_image_transport}};
}

WaitingOptions ImageInput::waitingOptions() const {
  WaitingOptions options;
  const bool stereo = parameters_.input == InputKind::kStereo, pair = parameters_.input == InputKind::kPair;
  if (pair) options.first = &ImageWithInfo::reference;
  if (streams_.size() > 1) {
    options.second = pair ? &ImageWithInfo::image : stereo ? &ImageWithInfo::right : &ImageWithInfo::depth;
  }
  options.tolerance = stereo ? kStereoTolerance : kNear;
  options.info_of_each = exactInfo();
  options.for_camera_info = !parameters_.camera.calibrated() && !exactInfo();
  options.for_right_info = stereo;
  options.for_mask = parameters_.mask_sync == MaskSync::kExact;
  options.patience = kPatience;
  options.capacity = static_cast<size_t>(parameters_.queue_size);
  if (priors_) options.sensors_reach = [this](const std_msgs::Header& image) { return priors_->reaches(image); };
  return options;
}

void ImageInput::checkTransports() const {
  for (const ImageStream& stream : streams_) {
    if (stream.transport == "raw" || stream.transport == kCompressed) continue;  // the others are loaded to see
    const std::string prefix = "image_transport/";
    const std::vector<std::string> loadable = transport_.getLoadableTransports();
    if (std::find(loadable.begin(), loadable.end(), prefix + stream.transport) != loadable.end()) continue;
    std::string installed = " '" + kCompressed + "'";
    for (const std::string& name : loadable) {
      if (name != prefix + kCompressed) installed += " '" + name.substr(prefix.size()) + "'";
    }
    throw std::invalid_argument(
        "parameter " + pnh_.resolveName(stream.transport_parameter) + " is '" + stream.transport +
        "'; it must be one of the transports that are installed:" + installed + "; " + whereToGet(stream.transport));
  }
}

void ImageInput::start() {
  if (started_) return;
  looking_ = false;
  subscribers_.clear();
  // The code of a transport, which may have to free images, stays loaded.
  const auto before = std::exchange(image_subscribers_, {});
  look_timer_ = nh_.createSteadyTimer(ros::WallDuration(kRest), [this](const ros::SteadyTimerEvent&) { lookAgain(); });
  if (priors_) priors_->start([this] { settle([] {}); });
  const auto queue = static_cast<uint32_t>(parameters_.queue_size);
  subscribers_.push_back(pnh_.subscribe<sensor_msgs::Image>(
      "mask", queue, [this](const sensor_msgs::ImageConstPtr& mask) { settle([&] { waiting_.addMask(mask); }); }));
  // If ~camera replaces it, it still shows if that is of another camera.
  subscribers_.push_back(
      nh_.subscribe<sensor_msgs::CameraInfo>(infoName(), queue, [this](const sensor_msgs::CameraInfoConstPtr& info) {
        settle([&] {
          ++infos_;
          last_info_stamp_ = info->header.stamp;
          waiting_.addCameraInfo(info);
        });
      }));
  if (parameters_.input == InputKind::kStereo) {
    subscribers_.push_back(nh_.subscribe<sensor_msgs::CameraInfo>(
        "right/camera_info", queue,
        [this](const sensor_msgs::CameraInfoConstPtr& info) { settle([&] { waiting_.setRightInfo(info); }); }));
  }
  if (parameters_.input == InputKind::kKeypoints) {
    subscribeKeypoints();
  } else {
    subscribe(0, [this](const sensor_msgs::ImageConstPtr& image) { add(image); });
  }
  if (streams_.size() > 1) subscribe(1, [this](const sensor_msgs::ImageConstPtr& image) { waiting_.addSecond(image); });
  started_ = true;
}

void ImageInput::subscribe(size_t stream, const std::function<void(const sensor_msgs::ImageConstPtr&)>& add) {
  const ImageStream& images = streams_[stream];
  if (images.transport == kCompressed) {
    subscribers_.push_back(nh_.subscribe<sensor_msgs::CompressedImage>(
        topic(stream) + "/" + kCompressed, static_cast<uint32_t>(parameters_.queue_size),
        [this, add](const sensor_msgs::CompressedImageConstPtr& image) {
          settle([&] { add(stillCompressed(*image)); });
        },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
    image_subscribers_.emplace_back();
    return;
  }
  // Without the private handle the transport would be looked up in the nodelet manager's namespace.
  const image_transport::TransportHints hints(images.transport, ros::TransportHints().tcpNoDelay(), pnh_,
                                              images.transport_parameter);
  // A transport appends its name to the topic first, and "image/compressed" is not what was remapped. Raw images are
  // subscribed to as they are named: a resolved name would be remapped a second time.
  image_subscribers_.push_back(transport_.subscribe(
      images.transport == "raw" ? images.name : topic(stream), static_cast<uint32_t>(parameters_.queue_size),
      [this, add](const sensor_msgs::ImageConstPtr& image) { settle([&] { add(image); }); }, ros::VoidPtr(), hints));
}

void ImageInput::subscribeKeypoints() {
  const auto receive = [this](const KeypointsConstPtr& keypoints) {
    const auto image = boost::make_shared<sensor_msgs::Image>();
    image->header = keypoints->header;
    image->width = keypoints->width;
    image->height = keypoints->height;
    settle([&] { add(image, keypoints); });
  };
  subscribers_.push_back(nh_.subscribe<Keypoints>(streams_[0].name, static_cast<uint32_t>(parameters_.queue_size),
                                                  receive, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
}

void ImageInput::add(const sensor_msgs::ImageConstPtr& image, const KeypointsConstPtr& keypoints) {
  ++images_;
  last_image_stamp_ = image->header.stamp;
  waiting_.add(image, ros::Time::now(), ros::SteadyTime::now().toSec(), keypoints);
}

void ImageInput::stop() {
  if (priors_) priors_->stop();
  for (image_transport::Subscriber& subscriber : image_subscribers_) subscriber.shutdown();
  subscribers_.clear();
  look_timer_.stop();  // after all that makes it run
  started_ = false;
  std::lock_guard<std::mutex> lock(mutex_);
  waiting_.clear();
}

void ImageInput::settle(const std::function<void()>& change) {
  std::vector<ImageWithInfo> settled;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    change();
    const int unpaired = waiting_.unpaired();
    settled = waiting_.settled(ros::SteadyTime::now().toSec());
    if (waiting_.pending()) keepLooking(true);
    if (waiting_.unpaired() > unpaired) {
      throttle_.warn("unpaired", "images on " + topic(0) + " have no camera_info of their stamp on " + infoTopic() +
                                     " and are left out (" + std::to_string(waiting_.unpaired()) +
                                     " so far); set ~camera_info_sync to latest if their stamps differ");
    }
    // A missing camera_info of the left or only camera is reported with the first pair.
    if (waiting_.gaveUpCameraInfo() && waiting_.lacksRightInfo()) {
      throttle_.warnOnce("right camera_info", "no camera_info came on " + rightInfoTopic() +
                                                  " with the first images: they are answered without a length until "
                                                  "one does");
    }
  }
  for (const ImageWithInfo& input : settled) callback_(input);
}

void ImageInput::lookAgain() {
  settle([] {});
  std::lock_guard<std::mutex> lock(mutex_);
  if (!waiting_.pending()) keepLooking(false);
}

void ImageInput::keepLooking(bool looking) {
  if (looking == looking_) return;
  looking_ = looking;
  look_timer_.setPeriod(ros::WallDuration(looking ? kLookPeriod : kRest));
}

std::optional<int> ImageInput::unpaired() {
  if (!exactInfo()) return std::nullopt;
  std::lock_guard<std::mutex> lock(mutex_);
  return waiting_.unpaired();
}

std::vector<InputTopic> ImageInput::inputs() const {
  std::vector<InputTopic> inputs = {{infoName(), infoTopic(), "sensor_msgs/CameraInfo"},
                                    {"~mask", pnh_.resolveName("mask"), "sensor_msgs/Image"}};
  for (const ImageStream& stream : streams_) {
    const std::string topic = nh_.resolveName(stream.name);
    if (parameters_.input == InputKind::kKeypoints) {
      inputs.push_back({stream.name, topic, "gms_ransac/Keypoints"});
      continue;
    }
    if (stream.transport == "raw") inputs.push_back({stream.name, topic, "sensor_msgs/Image"});
    if (stream.transport == kCompressed) {
      inputs.push_back({stream.name, topic + "/compressed", "sensor_msgs/CompressedImage"});
    }
  }
  if (parameters_.input == InputKind::kStereo) {
    inputs.push_back({"right/camera_info", rightInfoTopic(), "sensor_msgs/CameraInfo"});
  }
  return inputs;
}

std::string ImageInput::mixedTopic() const {
  std::string mixed;
  const auto look = [&](const auto& subscriber) {
    const uint32_t publishers = subscriber.getNumPublishers();
    if (publishers < 2 || !mixed.empty()) return;
    mixed = std::to_string(publishers) + " nodes publish " + subscriber.getTopic() +
            ", and what they send is taken for one camera's; stop all but one, or remap them apart";
  };
  for (const image_transport::Subscriber& subscriber : image_subscribers_) look(subscriber);
  for (const ros::Subscriber& subscriber : subscribers_) look(subscriber);
  return mixed;
}

std::string ImageInput::waitingFor(const Topics& published) {
  std::lock_guard<std::mutex> lock(mutex_);
  const int images = std::exchange(images_, 0), infos = std::exchange(infos_, 0);
  const bool matched = std::exchange(matched_, waiting_.matched()) != waiting_.matched();
  const auto subscribed = [&](size_t stream) {
    const std::string& transport = streams_[stream].transport;
    return topic(stream) + (transport == "raw" ? "" : "/" + transport);
  };
  // One of another type is reported as that.
  const auto isPublished = [&](size_t stream) {
    const bool connected = stream < image_subscribers_.size() && image_subscribers_[stream].getNumPublishers() > 0;
    return connected || published.count(subscribed(stream)) > 0;
  };
  const bool was_published = std::exchange(is_published_, isPublished(0));
  if (!started_ || matched) return std::string();
  const auto nobodyPublishes = [&](size_t stream) {
    if (parameters_.input == InputKind::kKeypoints) {
      return "nobody publishes " + subscribed(stream) +
             "; start the node that finds the keypoints (such as publish_keypoints.py), or remap 'keypoints' to its "
             "topic";
    }
    return "nobody publishes " + subscribed(stream) + "; start the camera or the bag, or remap '" +
           streams_[stream].name + "' to its topic: " + imagesElsewhere(published, streams_[stream].name, inputs());
  };
  if (images == 0) {
    if (!is_published_) return nobodyPublishes(0);
    // A publisher that has just come may not have sent any yet.
    if (!was_published) return std::string();
    return "no image arrives on " + subscribed(0) + ", although it has a publisher; check it with rostopic hz";
  }
  std::ostringstream text;
  if (streams_.size() > 1) {
    if (isPublished(1)) {
      text << "no image of " << topic(0) << " (last stamp " << last_image_stamp_ << ") has a partner within "
           << waitingOptions().tolerance << " s on " << topic(1);
    } else {
      text << nobodyPublishes(1);
    }
    if (parameters_.input != InputKind::kPair) text << "; images are answered without a length";
  } else if (exactInfo()) {
    text << "no image of " << topic(0) << " has a camera_info of the same stamp on " << infoTopic() << ": " << images
         << " images (last stamp " << last_image_stamp_ << ") and " << infos << " camera_info (last stamp "
         << last_info_stamp_ << ") came; set ~camera_info_sync to latest if their stamps differ";
  }
  return text.str();
}

}  // namespace gms_ransac
