#include "image_input.h"

#include <sstream>

namespace gms_ransac {

ImageInput::ImageInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters,
                       Callback callback)
    : nh_(nh), pnh_(pnh), transport_(nh), parameters_(parameters), callback_(std::move(callback)) {}

void ImageInput::start() {
  if (started_) return;
  const auto queue = static_cast<uint32_t>(parameters_.queue_size);
  // Without the private handle the transport would be looked up in the nodelet manager's namespace.
  const image_transport::TransportHints hints(parameters_.image_transport, ros::TransportHints().tcpNoDelay(), pnh_);
  if (!needsInfo() || parameters_.camera_info_sync == CameraInfoSync::kLatest) {
    if (needsInfo()) info_subscriber_ = nh_.subscribe("camera_info", queue, &ImageInput::onInfo, this);
    image_subscriber_ = transport_.subscribe("image", queue, &ImageInput::onImage, this, hints);
  } else {
    image_filter_.subscribe(transport_, "image", queue, hints);
    info_filter_.subscribe(nh_, "camera_info", queue);
    image_filter_.registerCallback([this](const sensor_msgs::ImageConstPtr& image) {
      std::lock_guard<std::mutex> lock(mutex_);
      ++images_;
      last_image_stamp_ = image->header.stamp;
    });
    info_filter_.registerCallback(&ImageInput::onInfo, this);
    synchronizer_ =
        std::make_unique<message_filters::Synchronizer<ExactPolicy>>(ExactPolicy(queue), image_filter_, info_filter_);
    synchronizer_->setReset(true);  // or pairing stops for good when a bag loops
    synchronizer_->registerCallback(&ImageInput::onPair, this);
  }
  started_ = true;
}

void ImageInput::stop() {
  image_subscriber_.shutdown();
  info_subscriber_.shutdown();
  image_filter_.unsubscribe();
  info_filter_.unsubscribe();
  synchronizer_.reset();
  started_ = false;
}

void ImageInput::onImage(const sensor_msgs::ImageConstPtr& image) {
  sensor_msgs::CameraInfoConstPtr info;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ++images_;
    last_image_stamp_ = image->header.stamp;
    info = latest_info_;
  }
  deliver(image, info);
}

void ImageInput::onInfo(const sensor_msgs::CameraInfoConstPtr& info) {
  std::lock_guard<std::mutex> lock(mutex_);
  ++infos_;
  last_info_stamp_ = info->header.stamp;
  latest_info_ = info;
}

void ImageInput::onPair(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::CameraInfoConstPtr& info) {
  deliver(image, info);
}

void ImageInput::deliver(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::CameraInfoConstPtr& info) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ++delivered_;
  }
  callback_({image, info, ros::Time::now()});
}

std::string ImageInput::waitingFor() {
  std::lock_guard<std::mutex> lock(mutex_);
  const int images = images_, infos = infos_, delivered = delivered_;
  images_ = infos_ = delivered_ = 0;
  if (!started_ || delivered > 0) return std::string();
  const std::string image_topic = nh_.resolveName("image"), info_topic = nh_.resolveName("camera_info");
  if (images == 0) return "no image arrives on " + image_topic;
  std::ostringstream text;
  text << "no image of " << image_topic << " has a camera_info of the same stamp on " << info_topic << ": " << images
       << " images (last stamp " << last_image_stamp_ << ") and " << infos << " camera_info (last stamp "
       << last_info_stamp_ << ") came; set ~camera_info_sync to latest if their stamps differ";
  return text.str();
}

}  // namespace gms_ransac
