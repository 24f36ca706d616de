// Bags: written of fuzzed messages, whole or cut. They are read, or refused with a DatasetError that names the file.
#include <cmath>
#include <iterator>

#include <rosbag/bag.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include "datasets/dataset.h"
#include "fuzz_messages.h"
#include "scratch_folder.h"

namespace gms_ransac {
namespace {

tf2_msgs::TFMessage fuzzedTransforms(FuzzInput& input) {
  static const std::array<const char*, 5> kFrames = {"world", "camera", "camera_left", "/base", ""};
  tf2_msgs::TFMessage message;
  for (int n = input.between(0, 4); n > 0; --n) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = fuzzedStamp(input);
    transform.header.frame_id = input.oneOf(kFrames);
    transform.child_frame_id = input.oneOf(kFrames);
    transform.transform.translation.x = input.number(-10, 10);
    transform.transform.rotation.w = input.number(0, 1);
    transform.transform.rotation.x = input.number(0, 1);
    message.transforms.push_back(transform);
  }
  return message;
}

void writeBag(FuzzInput& input, const std::string& file) {
  static const std::vector<std::string> kEncodings = {"mono8", "bgr8", "mono16", "bayer_rggb8"};
  rosbag::Bag bag(file, rosbag::bagmode::Write);
  bag.setCompression(static_cast<rosbag::CompressionType>(input.between(0, 2)));
  for (int n = input.between(1, 6); n > 0; --n) {
    const ros::Time received(1 + input.byte(), input.byte());
    const int kind = input.between(0, 5);
    if (kind == 0) {
      bag.write("/camera/camera_info", received, *fuzzedCameraInfo(input, 64, 64));
    } else if (kind == 1) {
      bag.write(input.flag() ? "/tf" : "/tf_static", received, fuzzedTransforms(input));
    } else if (kind == 2) {
      bag.write(input.flag() ? "/camera/image_raw" : "/camera/camera_info", received, std_msgs::String());
    } else {
      const sensor_msgs::ImagePtr image = fuzzedImage(input, kEncodings, 70);
      image->header.frame_id = "camera";
      bag.write("/camera/image_raw", received, *image);
    }
  }
}

std::string contentOf(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace

void check(FuzzInput input) {
  quietRos();
  static const ScratchFolder folder;
  const std::string file = folder.path("fuzzed.bag");
  try {
    writeBag(input, file);
  } catch (const rosbag::BagException&) {
    return;  // it was not to be written, so there is nothing to read
  }
  if (input.flag()) {
    const std::string bytes = contentOf(file);
    folder.write("fuzzed.bag", bytes.substr(0, input.raw<uint32_t>() % bytes.size()));
  }
  try {
    const Dataset set = Dataset::open(file);
    for (const DatasetFrame& frame : set.frames()) {
      demand(!frame.pose || frame.pose->matrix().allFinite(), "a pose is finite");
    }
    if (set.intrinsics()) set.intrinsics()->validate();
    for (int i = 0; i < static_cast<int>(set.frames().size()); ++i) demand(!set.image(i).empty(), "an image is one");
  } catch (const DatasetError& error) {
    demand(std::string(error.what()).find(file) != std::string::npos, "a complaint names the file");
  }
}

}  // namespace gms_ransac
