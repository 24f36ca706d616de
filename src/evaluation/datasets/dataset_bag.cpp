// ROS bags: an image topic (raw or compressed), its camera_info, and the true motion of the camera from tf. Needs no
// ROS master.
#include <memory>
#include <mutex>
#include <set>

#include <cv_bridge/cv_bridge.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>
#include <boost/algorithm/string/join.hpp>

#include "camera/camera_info.h"
#include "datasets/dataset_text.h"
#include "features/encoded_image.h"

namespace gms_ransac {

namespace {

// Grey or colour camera topics of the official TUM bags and of kitti2bag.
constexpr const char* kUsualTopics[] = {"/camera/rgb/image_color", "/kitti/camera_gray_left/image_raw"};
constexpr const char* kTruthFrames[] = {"world", "map", "odom"};

std::string parentTopic(const std::string& topic) {
  const auto slash = topic.rfind('/');
  return slash == std::string::npos ? "" : topic.substr(0, slash);
}

bool ofDepth(const std::string& topic) { return topic.find("depth") != std::string::npos; }

/// The pixels of a message. Without a colour format (8UC1, 16UC3, ...) they are grey or in OpenCV's order.
cv::Mat pixelsOf(const sensor_msgs::Image& raw, const std::string& topic, bool colour) {
  namespace encodings = sensor_msgs::image_encodings;
  if (encodings::bitDepth(raw.encoding) > 16 || (raw.encoding == encodings::TYPE_16UC1 && ofDepth(topic))) {
    throw DatasetError("its encoding " + raw.encoding +
                       " is that of a depth image; choose grey or colour with --topic");
  }
  sensor_msgs::Image named = raw;
  const bool wide = encodings::bitDepth(raw.encoding) == 16;
  if (raw.encoding.find("UC") != std::string::npos) {
    const int channels = encodings::numChannels(raw.encoding);
    named.encoding = std::string(channels == 1 ? "mono" : channels == 4 ? "bgra" : "bgr") + (wide ? "16" : "8");
  }
  return eightBits(cv_bridge::toCvCopy(named, wide ? "mono16" : colour ? "bgr8" : "mono8")->image, colour);
}

/// An open bag, and where its images are.
struct OpenBag {
  rosbag::Bag bag;
  std::vector<rosbag::MessageInstance> messages;
  std::mutex mutex;

  cv::Mat image(int frame, bool colour) {
    const rosbag::MessageInstance& message = messages.at(static_cast<size_t>(frame));
    const std::lock_guard<std::mutex> lock(mutex);
    std::string problem = "it has no pixels, or cannot be decoded";
    cv::Mat found;
    try {
      if (const auto raw = message.instantiate<sensor_msgs::Image>()) {
        found = pixelsOf(*raw, message.getTopic(), colour);
      } else if (const auto packed = message.instantiate<sensor_msgs::CompressedImage>()) {
        const DecodedImage decoded = decodeImage(packed->data, packed->format);
        const cv_bridge::CvImage image(packed->header, decoded.encoding, decoded.pixels);
        if (!decoded.pixels.empty()) found = pixelsOf(*image.toImageMsg(), message.getTopic(), colour);
      }
    } catch (const std::exception& error) {  // a damaged message may make any layer throw
      problem = error.what();
    }
    if (!found.empty()) return found;
    throw DatasetError(bag.getFileName() + ": image " + std::to_string(frame) + " of " + message.getTopic() + ": " +
                       problem);
  }
};

std::string chooseTopic(const std::string& file, rosbag::Bag& bag, const std::string& asked) {
  if (!asked.empty()) return asked;
  std::set<std::string> topics;
  const rosbag::TypeQuery images(std::vector<std::string>{"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
  for (const rosbag::ConnectionInfo* connection : rosbag::View(bag, images).getConnections()) {
    if (!ofDepth(connection->topic)) topics.insert(connection->topic);
  }
  if (topics.empty()) throw DatasetError(file + ": holds no image topic");
  if (topics.size() == 1) return *topics.begin();
  for (const char* usual : kUsualTopics) {
    if (topics.count(usual) > 0) return usual;
  }
  throw DatasetError(file + ": holds several image topics (" + boost::algorithm::join(topics, ", ") +
                     "); choose one with --topic");
}

/// The first camera_info of an image topic. Puts its topic and matrix into `source`, and into `advice` what to give if
/// the guess is wrong.
std::optional<CameraIntrinsics> readCameraInfo(const std::string& file, rosbag::Bag& bag, const std::string& topic,
                                               Rectified given, std::string& source, std::string& advice) {
  // ".../image_raw/compressed" has its camera_info one level further up.
  for (const std::string& parent : {parentTopic(topic), parentTopic(parentTopic(topic))}) {
    const std::string info_topic = parent + "/camera_info";
    rosbag::View view(bag, rosbag::TopicQuery(info_topic));
    for (const rosbag::MessageInstance& message : view) {
      const auto info = message.instantiate<sensor_msgs::CameraInfo>();
      if (!info) continue;
      try {
        const CameraIntrinsics intrinsics = intrinsicsOf(*info, topic, given, " or give --intrinsics");
        if (!intrinsics.calibrated()) return std::nullopt;
        intrinsics.validate();
        const bool rectified = isRectified(*info, topic, given);
        source = info_topic + (rectified && info->P[0] != 0 ? ", P" : rectified ? ", K" : ", K and D");
        if (given == Rectified::kAuto && rectified != isRectified(*info, "", Rectified::kAuto)) {
          advice = " (taken as rectified by the topic's name; if they are not, give --input-is-rectified false)";
        } else if (given == Rectified::kAuto && !rectified && info->P[0] != 0) {
          advice = " (taken as not rectified; if they are, give --input-is-rectified true)";
        }
        return intrinsics;
      } catch (const std::invalid_argument& error) {
        throw DatasetError(file + ": " + info_topic + ": " + error.what());
      }
    }
  }
  return std::nullopt;
}

/// Fills in the poses of frames from tf; silently none when the camera hangs in no known world.
void addPoses(rosbag::Bag& bag, const std::string& camera_frame, const std::vector<ros::Time>& stamps,
              std::vector<DatasetFrame>& frames) {
  tf2::BufferCore buffer(ros::Duration(1e9));  // nothing is forgotten
  for (const bool is_static : {false, true}) {
    rosbag::View view(bag, rosbag::TopicQuery(is_static ? std::vector<std::string>{"/tf_static", "tf_static"}
                                                        : std::vector<std::string>{"/tf", "tf"}));
    for (const rosbag::MessageInstance& message : view) {
      const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
      if (!transforms) continue;
      for (const auto& transform : transforms->transforms) buffer.setTransform(transform, "bag", is_static);
    }
  }
  for (const char* world : kTruthFrames) {
    // The truth of kitti2bag's odometry bags moves "camera_left", which no image names as its frame.
    for (const std::string& camera : {camera_frame, std::string("camera_left")}) {
      if (!buffer.canTransform(world, camera, ros::Time(0))) continue;
      for (size_t i = 0; i < frames.size(); ++i) {
        if (!buffer.canTransform(world, camera, stamps[i])) continue;
        const auto transform = buffer.lookupTransform(world, camera, stamps[i]).transform;
        Eigen::Quaterniond rotation;
        tf2::fromMsg(transform.rotation, rotation);
        const auto& p = transform.translation;
        frames[i].pose = Eigen::Translation3d(p.x, p.y, p.z) * rotation.normalized();
      }
      return;
    }
  }
}

}  // namespace

void Dataset::readBag(const DatasetOptions& options) {
  try {
    const auto open = std::make_shared<OpenBag>();
    rosbag::Bag& bag = open->bag;
    bag.open(path_, rosbag::bagmode::Read);
    const std::string topic = chooseTopic(path_, bag, options.topic);
    std::vector<ros::Time> stamps;
    std::string camera_frame;
    rosbag::View view(bag, rosbag::TopicQuery(topic));
    for (const rosbag::MessageInstance& message : view) {
      std_msgs::Header header;
      if (const auto raw = message.instantiate<sensor_msgs::Image>()) {
        header = raw->header;
      } else if (const auto packed = message.instantiate<sensor_msgs::CompressedImage>()) {
        header = packed->header;
      } else {
        throw DatasetError(path_ + ": topic " + topic + " carries " + message.getDataType() + ", not images");
      }
      camera_frame = header.frame_id.substr(header.frame_id.rfind('/', 0) == 0 ? 1 : 0);  // tf2 has none
      open->messages.push_back(message);
      stamps.push_back(header.stamp);
      const double stamp = header.stamp.toSec();
      frames_.push_back({topic + "@" + std::to_string(stamp), stamp});
    }
    if (open->messages.empty()) throw DatasetError(path_ + ": topic " + topic + " holds no image");
    if (options.intrinsics.empty()) {
      intrinsics_ = readCameraInfo(path_, bag, topic, options.rectified, intrinsics_source_, advice_);
    }
    addPoses(bag, camera_frame, stamps, frames_);
    read_ = [open](int frame, bool colour) { return open->image(frame, colour); };
  } catch (const DatasetError&) {
    throw;
  } catch (const tf2::TransformException& error) {
    throw DatasetError(path_ + ": its transforms are inconsistent (" + error.what() + ")");
  } catch (const std::exception& error) {  // a damaged bag makes rosbag, the messages and boost throw, each its own
    throw DatasetError(path_ + ": cannot be read as a bag (" + error.what() + ")");
  }
}

}  // namespace gms_ransac
