#include "input/image_input.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <vector>

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

/// Advice on the package that contains a transport.
std::string whereToGet(const std::string& transport) {
  std::string package;
  if (transport == "compressed" || transport == "theora") package = transport;
  if (transport == "compressedDepth") package = "compressed-depth";
  if (package.empty()) return "check the spelling, or install the package that brings it";
  return "'" + transport + "' comes with the package ros-noetic-" + package +
         "-image-transport (where there is none, build image_transport_plugins)";
}

double tolerance(const Parameters& parameters) {
  return parameters.input == InputKind::kStereo ? kStereoTolerance : kNear;
}

PairingOptions pairingOptions(const Parameters& parameters) {
  return {tolerance(parameters), kPatience, static_cast<size_t>(parameters.queue_size)};
}

WaitingOptions waitingOptions(const Parameters& parameters, const std::shared_ptr<MotionPriors>& priors) {
  WaitingOptions options;
  options.for_camera_info = !parameters.camera.calibrated();
  options.for_right_info = parameters.input == InputKind::kStereo;
  options.for_mask = parameters.mask_sync == MaskSync::kExact;
  options.patience = kPatience;
  options.capacity = static_cast<size_t>(parameters.queue_size);
  if (priors) options.sensors_reach = [priors](const std_msgs::Header& image) { return priors->reaches(image); };
  return options;
}

}  // namespace

template <typename Change>
void ImageInput::settle(const Change& change) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    change();
  }
  deliverSettled();
}

ImageInput::ImageInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters,
                       Callback callback, std::shared_ptr<MotionPriors> priors)
    : nh_(nh),
      pnh_(pnh),
      transport_(nh),
      parameters_(parameters),
      callback_(std::move(callback)),
      priors_(std::move(priors)),
      throttle_(parameters.name),
      pairing_(pairingOptions(parameters)),
      waiting_(waitingOptions(parameters, priors_)) {}

void ImageInput::checkTransports() const {
  checkTransport("image_transport", parameters_.image_transport);
  if (parameters_.scale == ScaleMode::kDepth) {
    checkTransport("depth_image_transport", parameters_.depth_image_transport);
  }
}

void ImageInput::checkTransport(const std::string& parameter, const std::string& transport) const {
  if (transport == "raw") return;  // always there; the others are loaded to see
  const std::string prefix = "image_transport/";
  const std::vector<std::string> loadable = transport_.getLoadableTransports();
  if (std::find(loadable.begin(), loadable.end(), prefix + transport) != loadable.end()) return;
  std::string installed;
  for (const std::string& name : loadable) installed += " '" + name.substr(prefix.size()) + "'";
  throw std::invalid_argument("parameter " + pnh_.resolveName(parameter) + " is '" + transport +
                              "'; it must be one of the transports that are installed:" + installed + "; " +
                              whereToGet(transport));
}

void ImageInput::start() {
  if (started_) return;
  looking_ = false;
  look_timer_ = nh_.createSteadyTimer(ros::WallDuration(kRest), [this](const ros::SteadyTimerEvent&) { lookAgain(); });
  if (priors_) priors_->start([this] { deliverSettled(); });
  const auto queue = static_cast<uint32_t>(parameters_.queue_size);
  // Without the private handle the transport would be looked up in the nodelet manager's namespace.
  const image_transport::TransportHints hints(parameters_.image_transport, ros::TransportHints().tcpNoDelay(), pnh_);
  mask_subscriber_ = pnh_.subscribe<sensor_msgs::Image>(
      "mask", queue, [this](const sensor_msgs::ImageConstPtr& mask) { settle([&] { waiting_.addMask(mask); }); });
  if (exactInfo()) {
    startExact(queue, hints);
  } else {
    // If ~camera replaces it, it still shows if that is of another camera.
    info_subscriber_ = nh_.subscribe(infoName(), queue, &ImageInput::onInfo, this);
    if (twoImages()) {
      startTwoImages(queue, hints);
    } else {
      image_subscriber_ = transport_.subscribe(toSubscribe(firstName(), parameters_.image_transport), queue,
                                               &ImageInput::onImage, this, hints);
    }
  }
  started_ = true;
}

void ImageInput::startExact(uint32_t queue, const image_transport::TransportHints& hints) {
  image_filter_.subscribe(transport_, toSubscribe(firstName(), parameters_.image_transport), queue, hints);
  info_filter_.subscribe(nh_, "camera_info", queue);
  image_filter_.registerCallback(&ImageInput::countImage, this);
  info_filter_.registerCallback(&ImageInput::onInfo, this);
  synchronizer_ =
      std::make_unique<message_filters::Synchronizer<ExactPolicy>>(ExactPolicy(queue), image_filter_, info_filter_);
  synchronizer_->setReset(true);  // or pairing stops for good when a bag loops
  synchronizer_->registerCallback(&ImageInput::onPair, this);
  synchronizer_->getPolicy()->registerDropCallback(&ImageInput::onUnpaired, this);
}

void ImageInput::startTwoImages(uint32_t queue, const image_transport::TransportHints& hints) {
  const bool alike = parameters_.input != InputKind::kStream;
  if (parameters_.input == InputKind::kStereo) {
    right_info_subscriber_ = nh_.subscribe<sensor_msgs::CameraInfo>(
        "right/camera_info", queue,
        [this](const sensor_msgs::CameraInfoConstPtr& info) { settle([&] { waiting_.setRightInfo(info); }); });
  }
  image_subscriber_ = transport_.subscribe(toSubscribe(firstName(), parameters_.image_transport), queue,
                                           &ImageInput::onFirst, this, hints);
  // Depth is never sent through the transport of the images: lossy ones spoil it.
  second_subscriber_ = transport_.subscribe(
      toSubscribe(secondName(), alike ? parameters_.image_transport : parameters_.depth_image_transport), queue,
      &ImageInput::onSecond, this,
      alike ? hints : image_transport::TransportHints("raw", ros::TransportHints(), pnh_, "depth_image_transport"));
}

void ImageInput::stop() {
  if (priors_) priors_->stop();
  image_subscriber_.shutdown();
  second_subscriber_.shutdown();
  info_subscriber_.shutdown();
  mask_subscriber_.shutdown();
  right_info_subscriber_.shutdown();
  image_filter_.unsubscribe();
  info_filter_.unsubscribe();
  synchronizer_.reset();
  look_timer_.stop();  // after all that makes it run
  started_ = false;
  std::lock_guard<std::mutex> lock(mutex_);
  pairing_.clear();
  waiting_.clear();
}

void ImageInput::countImage(const sensor_msgs::ImageConstPtr& image) {
  std::lock_guard<std::mutex> lock(mutex_);
  ++images_;
  last_image_stamp_ = image->header.stamp;
}

void ImageInput::onImage(const sensor_msgs::ImageConstPtr& image) {
  countImage(image);
  ImageWithInfo input;
  input.image = image;
  deliver(input);
}

void ImageInput::onFirst(const sensor_msgs::ImageConstPtr& image) {
  countImage(image);
  {
    std::lock_guard<std::mutex> lock(mutex_);
    pairing_.addFirst(image, ros::SteadyTime::now().toSec());
  }
  deliverPairs();
}

void ImageInput::onSecond(const sensor_msgs::ImageConstPtr& image) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    pairing_.addSecond(image);
  }
  deliverPairs();
}

void ImageInput::deliverPairs() {
  std::vector<ImagePair> pairs;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    pairs = pairing_.settled(ros::SteadyTime::now().toSec());
    if (pairing_.pending()) keepLooking(true);
  }
  for (const ImagePair& pair : pairs) {
    ImageWithInfo input;
    if (parameters_.input == InputKind::kStream) {
      input.image = pair.first;
      input.depth = pair.second;
    } else if (parameters_.input == InputKind::kStereo) {
      input.image = pair.first;
      input.right = pair.second;
    } else if (pair.second) {
      input.reference = pair.first;
      input.image = pair.second;
    } else {
      continue;
    }
    deliver(input);
  }
}

void ImageInput::onInfo(const sensor_msgs::CameraInfoConstPtr& info) {
  settle([&] {
    ++infos_;
    last_info_stamp_ = info->header.stamp;
    waiting_.setCameraInfo(info);
  });
}

void ImageInput::onPair(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::CameraInfoConstPtr& info) {
  ImageWithInfo input;
  input.image = image;
  input.camera_info = info;
  deliver(input);
}

void ImageInput::onUnpaired(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::CameraInfoConstPtr& /*info*/) {
  if (!image) return;
  std::lock_guard<std::mutex> lock(mutex_);
  ++unpaired_;
  throttle_.warn("unpaired", "images on " + firstTopic() + " have no camera_info of their stamp on " + infoTopic() +
                                 " and are left out (" + std::to_string(unpaired_) +
                                 " so far); set ~camera_info_sync to latest if their stamps differ");
}

std::optional<int> ImageInput::unpaired() {
  if (!exactInfo()) return std::nullopt;
  std::lock_guard<std::mutex> lock(mutex_);
  return unpaired_;
}

void ImageInput::deliver(ImageWithInfo input) {
  input.received = ros::Time::now();
  settle([&] {
    if (!twoImages() || input.depth || input.reference || input.right) ++complete_;
    waiting_.add(input, ros::SteadyTime::now().toSec());
  });
}

void ImageInput::deliverSettled() {
  std::vector<ImageWithInfo> settled;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    settled = waiting_.settled(ros::SteadyTime::now().toSec());
    if (waiting_.pending()) keepLooking(true);
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
  deliverPairs();
  deliverSettled();
  std::lock_guard<std::mutex> lock(mutex_);
  if (!pairing_.pending() && !waiting_.pending()) keepLooking(false);
}

void ImageInput::keepLooking(bool looking) {
  if (looking == looking_) return;
  looking_ = looking;
  look_timer_.setPeriod(ros::WallDuration(looking ? kLookPeriod : kRest));
}

std::vector<InputTopic> ImageInput::inputs() const {
  std::vector<InputTopic> inputs = {{infoName(), infoTopic(), "sensor_msgs/CameraInfo"},
                                    {"~mask", pnh_.resolveName("mask"), "sensor_msgs/Image"}};
  const auto addImages = [&](const std::string& name, const std::string& transport) {
    const std::string topic = nh_.resolveName(name);
    if (transport == "raw") inputs.push_back({name, topic, "sensor_msgs/Image"});
    if (transport == "compressed") inputs.push_back({name, topic + "/compressed", "sensor_msgs/CompressedImage"});
  };
  const bool alike = parameters_.input != InputKind::kStream;
  addImages(firstName(), parameters_.image_transport);
  if (twoImages()) addImages(secondName(), alike ? parameters_.image_transport : parameters_.depth_image_transport);
  if (parameters_.input == InputKind::kStereo) {
    inputs.push_back({"right/camera_info", rightInfoTopic(), "sensor_msgs/CameraInfo"});
  }
  return inputs;
}

std::string ImageInput::toSubscribe(const std::string& name, const std::string& transport) const {
  // A transport appends its name to the topic first, and "image/compressed" is not what was remapped. Raw images are
  // subscribed to as they are named: a resolved name would be remapped a second time.
  return transport == "raw" ? name : nh_.resolveName(name);
}

std::string ImageInput::nobodyPublishes(const std::string& topic, const char* name, const Topics& published) const {
  return "nobody publishes " + topic + "; start the camera or the bag, or remap '" + name +
         "' to its topic: " + imagesElsewhere(published, parameters_.name);
}

std::string ImageInput::whyNoImage(const Topics& published) const {
  const bool raw = parameters_.image_transport == "raw";
  const std::string topic = firstTopic() + (raw ? "" : "/" + parameters_.image_transport);
  const auto publishers = exactInfo() ? image_filter_.getNumPublishers() : image_subscriber_.getNumPublishers();
  if (publishers > 0)
    return "no image arrives on " + topic + ", although it has a publisher; check it with rostopic hz";
  return nobodyPublishes(topic, firstName(), published);
}

std::string ImageInput::whyNoPartner(const Topics& published) const {
  std::ostringstream text;
  if (second_subscriber_.getNumPublishers() == 0) {
    text << nobodyPublishes(secondTopic(), secondName(), published);
  } else {
    text << "no image of " << firstTopic() << " (last stamp " << last_image_stamp_ << ") has a partner within "
         << tolerance(parameters_) << " s on " << secondTopic();
  }
  if (parameters_.input != InputKind::kPair) text << "; images are answered without a length";
  return text.str();
}

std::string ImageInput::waitingFor(const Topics& published) {
  std::lock_guard<std::mutex> lock(mutex_);
  const int images = images_, infos = infos_, complete = complete_;
  images_ = infos_ = complete_ = 0;
  if (!started_ || complete > 0) return std::string();
  if (images == 0) return whyNoImage(published);
  if (twoImages()) return whyNoPartner(published);
  std::ostringstream text;
  text << "no image of " << firstTopic() << " has a camera_info of the same stamp on " << infoTopic() << ": " << images
       << " images (last stamp " << last_image_stamp_ << ") and " << infos << " camera_info (last stamp "
       << last_info_stamp_ << ") came; set ~camera_info_sync to latest if their stamps differ";
  return text.str();
}

}  // namespace gms_ransac
