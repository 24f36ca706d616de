// ROS bags: an image topic (raw or compressed), its camera_info, and the true motion of the camera from tf. Needs no
// ROS master.
#include <algorithm>
#include <memory>
#include <mutex>

#include <cv_bridge/cv_bridge.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/dataset_text.h"
#include "distortion.h"

namespace gms_ransac {

namespace {

constexpr char kImageType[] = "sensor_msgs/Image";
constexpr char kCompressedType[] = "sensor_msgs/CompressedImage";
// Grey or colour camera topics of the official TUM bags and of kitti2bag.
constexpr const char* kUsualTopics[] = {"/camera/rgb/image_color", "/kitti/camera_gray_left/image_raw"};
constexpr const char* kTruthFrames[] = {"world", "map", "odom"};

std::string withoutLeadingSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

std::string parentTopic(const std::string& topic) {
  const auto slash = topic.rfind('/');
  return slash == std::string::npos ? "" : topic.substr(0, slash);
}

/// The pixels of a message. Without a colour format (8UC1, 16UC3, ...) they are grey or in OpenCV's order.
cv::Mat pixelsOf(const sensor_msgs::Image& raw, bool colour) {
  namespace encodings = sensor_msgs::image_encodings;
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
        found = pixelsOf(*raw, colour);
      } else if (const auto packed = message.instantiate<sensor_msgs::CompressedImage>()) {
        const cv::Mat decoded = cv::imdecode(packed->data, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH);
        if (!decoded.empty()) found = eightBits(decoded, colour);
      }
    } catch (const std::exception& error) {  // a damaged message may make any layer throw
      problem = error.what();
    }
    if (!found.empty()) return found;
    throw DatasetError(bag.getFileName() + ": image " + std::to_string(frame) + " of " + message.getTopic() + ": " +
                       problem);
  }
};

/// Image topics of the bag by name; depth images announce themselves by theirs.
std::vector<std::string> imageTopics(rosbag::Bag& bag) {
  std::vector<std::string> topics;
  for (const rosbag::ConnectionInfo* connection : rosbag::View(bag).getConnections()) {
    if (connection->datatype != kImageType && connection->datatype != kCompressedType) continue;
    if (connection->topic.find("depth") == std::string::npos) topics.push_back(connection->topic);
  }
  std::sort(topics.begin(), topics.end());
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  return topics;
}

std::string chooseTopic(const std::string& file, rosbag::Bag& bag, const std::string& asked) {
  const std::vector<std::string> topics = imageTopics(bag);
  if (!asked.empty()) return asked;
  if (topics.empty()) throw DatasetError(file + ": holds no image topic");
  if (topics.size() == 1) return topics[0];
  for (const char* usual : kUsualTopics) {
    if (std::find(topics.begin(), topics.end(), usual) != topics.end()) return usual;
  }
  std::string known;
  for (const std::string& topic : topics) known += (known.empty() ? "" : ", ") + topic;
  throw DatasetError(file + ": holds several image topics (" + known + "); choose one with --topic");
}

CameraIntrinsics fromCameraInfo(const sensor_msgs::CameraInfo& info, const std::string& topic) {
  const CameraIntrinsics raw = {info.K[0], info.K[4], info.K[2], info.K[5], commonModelName(info.distortion_model),
                                info.D};
  const CameraIntrinsics rectified = {info.P[0], info.P[5], info.P[2], info.P[6], "", {}};
  // P describes rectified images; their topics may carry it alone.
  return rectified.calibrated() && (topic.find("_rect") != std::string::npos || !raw.calibrated()) ? rectified : raw;
}

/// Puts the topic into `source`.
std::optional<CameraIntrinsics> readCameraInfo(const std::string& file, rosbag::Bag& bag, const std::string& topic,
                                               std::string& source) {
  // ".../image_raw/compressed" has its camera_info one level further up.
  for (const std::string& parent : {parentTopic(topic), parentTopic(parentTopic(topic))}) {
    source = parent + "/camera_info";
    rosbag::View view(bag, rosbag::TopicQuery(source));
    for (const rosbag::MessageInstance& message : view) {
      const auto info = message.instantiate<sensor_msgs::CameraInfo>();
      if (!info) continue;
      const CameraIntrinsics intrinsics = fromCameraInfo(*info, topic);
      if (!intrinsics.calibrated()) return std::nullopt;
      try {
        intrinsics.validate();
      } catch (const std::invalid_argument& error) {
        throw DatasetError(file + ": " + source + ": " + error.what());
      }
      return intrinsics;
    }
  }
  return std::nullopt;
}

/// All transforms of the bag; nothing is forgotten.
class TransformTree {
 public:
  explicit TransformTree(rosbag::Bag& bag) : buffer_(ros::Duration(1e9)) {
    for (const bool is_static : {false, true}) {
      rosbag::View view(bag, rosbag::TopicQuery(is_static ? std::vector<std::string>{"/tf_static", "tf_static"}
                                                          : std::vector<std::string>{"/tf", "tf"}));
      for (const rosbag::MessageInstance& message : view) {
        const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
        if (!transforms) continue;
        for (geometry_msgs::TransformStamped transform : transforms->transforms) {
          transform.header.frame_id = withoutLeadingSlash(transform.header.frame_id);
          transform.child_frame_id = withoutLeadingSlash(transform.child_frame_id);
          buffer_.setTransform(transform, "bag", is_static);
        }
      }
    }
  }

  std::optional<Eigen::Isometry3d> pose(const std::string& world, const std::string& camera,
                                        const ros::Time& stamp) const {
    if (!buffer_.canTransform(world, camera, stamp)) return std::nullopt;
    const auto transform = buffer_.lookupTransform(world, camera, stamp).transform;
    const auto& q = transform.rotation;
    const auto& p = transform.translation;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(p.x, p.y, p.z);
    return pose;
  }

  bool connects(const std::string& world, const std::string& camera) const {
    return buffer_.canTransform(world, camera, ros::Time(0));
  }

 private:
  tf2::BufferCore buffer_;
};

/// Fills in the poses of frames from tf; silently none when the camera hangs in no known world.
void addPoses(rosbag::Bag& bag, const std::string& camera_frame, const std::vector<ros::Time>& stamps,
              std::vector<DatasetFrame>& frames) {
  const TransformTree tree(bag);
  for (const char* world : kTruthFrames) {
    // The truth of kitti2bag's odometry bags moves "camera_left", which no image names as its frame.
    for (const std::string& camera : {camera_frame, std::string("camera_left")}) {
      if (!tree.connects(world, camera)) continue;
      for (size_t i = 0; i < frames.size(); ++i) frames[i].pose = tree.pose(world, camera, stamps[i]);
      return;
    }
  }
}

}  // namespace

Dataset openBag(const std::string& file, const DatasetOptions& options) {
  Dataset dataset;
  dataset.kind_ = DatasetKind::kBag;
  try {
    const auto open = std::make_shared<OpenBag>();
    rosbag::Bag& bag = open->bag;
    bag.open(file, rosbag::bagmode::Read);
    const std::string topic = chooseTopic(file, bag, options.topic);
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
        throw DatasetError(file + ": topic " + topic + " carries " + message.getDataType() + ", not images");
      }
      camera_frame = withoutLeadingSlash(header.frame_id);
      open->messages.push_back(message);
      stamps.push_back(header.stamp);
      const double stamp = header.stamp.toSec();
      dataset.frames_.push_back({topic + "@" + std::to_string(stamp), stamp});
    }
    if (open->messages.empty()) throw DatasetError(file + ": topic " + topic + " holds no image");
    dataset.intrinsics_ = readCameraInfo(file, bag, topic, dataset.intrinsics_source_);
    addPoses(bag, camera_frame, stamps, dataset.frames_);
    dataset.read_ = [open](int frame, bool colour) { return open->image(frame, colour); };
  } catch (const DatasetError&) {
    throw;
  } catch (const tf2::TransformException& error) {
    throw DatasetError(file + ": its transforms are inconsistent (" + error.what() + ")");
  } catch (const std::exception& error) {  // a damaged bag makes rosbag, the messages and boost throw, each its own
    throw DatasetError(file + ": cannot be read as a bag (" + error.what() + ")");
  }
  return dataset;
}

}  // namespace gms_ransac
