#include <filesystem>
#include <stdexcept>

#include <rosbag/bag.h>
#include <rosbag/exceptions.h>
#include <sensor_msgs/Imu.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include "datasets/bag_writer.h"
#include "scenes/scene_writer.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;

const char kCameraFrame[] = "/openni_rgb_optical_frame", kImuFrame[] = "/imu";  // of BagLayout::kTum

geometry_msgs::Vector3 toMessage(const Eigen::Vector3d& v) {
  geometry_msgs::Vector3 message;
  tf2::toMsg(v, message);
  return message;
}

/// Puts the density's variance per sample on the diagonal.
void setVariance(double density, double rate, boost::array<double, 9>& covariance) {
  covariance.fill(0);
  covariance[0] = covariance[4] = covariance[8] = density * density * rate;
}

sensor_msgs::Imu toMessage(const ImuSample& sample, const ImuOptions& imu) {
  sensor_msgs::Imu message;
  message.header.stamp = ros::Time(sample.time);
  message.header.frame_id = kImuFrame;
  message.angular_velocity = toMessage(sample.angular_velocity);
  message.linear_acceleration = toMessage(sample.specific_force);
  message.orientation_covariance[0] = -1;  // no orientation, by its .msg
  setVariance(imu.gyro_noise, imu.rate, message.angular_velocity_covariance);
  setVariance(imu.accelerometer_noise, imu.rate, message.linear_acceleration_covariance);
  return message;
}

/// /imu, and in /tf at each image where it is on the camera.
void writeImu(const Scene& scene, int frames, rosbag::Bag& bag) {
  const SceneOptions& options = scene.options();
  for (const ImuSample& sample : scene.imuSamples(frames)) {
    const sensor_msgs::Imu message = toMessage(sample, options.imu);
    bag.write("/imu", message.header.stamp, message);
  }
  const Eigen::Translation3d offset(options.offset, 0, 0);
  for (int i = 0; i < frames; ++i) {
    tf2_msgs::TFMessage message;
    message.transforms = {tf2::eigenToTransform((options.imu.camera_in_imu * offset).inverse())};
    message.transforms[0].header.stamp = ros::Time(scene.stamp(i));
    message.transforms[0].header.frame_id = kCameraFrame;
    message.transforms[0].child_frame_id = kImuFrame;
    bag.write("/tf", message.transforms[0].header.stamp, message);
  }
}

/// Adds the IMU to a bag, which is .active meanwhile and does not stay if that fails.
void addImu(const Scene& scene, int frames, const std::string& path) {
  const std::string active = path + ".active";
  fs::rename(path, active);
  // Never destroyed: a bag that cannot be written ends the program when it closes itself.
  static rosbag::Bag* const bag = new rosbag::Bag;
  try {
    bag->open(active, rosbag::bagmode::Append);
    writeImu(scene, frames, *bag);
    bag->close();
  } catch (const rosbag::BagException&) {
    fs::remove(active);
    throw std::runtime_error(path + ": writing failed; is the disk full?");
  }
  fs::rename(active, path);
}

}  // namespace

void writeBag(const Scene& scene, int frames, const std::string& path, const std::function<void()>& written) {
  BagWriter bag(path, BagLayout::kTum, scene.intrinsics());
  for (int i = 0; i < frames; ++i) {
    const RenderedFrame frame = scene.render(i);
    bag.writeGroundTruth(frame.stamp, frame.camera_pose);
    bag.writeImage(frame.stamp, frame.image);
    bag.writeDepth(frame.stamp, frame.depth);
    written();
  }
  bag.close();
  if (scene.options().imu.rate > 0) addImu(scene, frames, path);
}

}  // namespace gms_ransac
