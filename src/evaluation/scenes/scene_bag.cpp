#include <sensor_msgs/Imu.h>
#include <tf2_eigen/tf2_eigen.h>

#include "datasets/bag_writer.h"
#include "scenes/scene_writer.h"

namespace gms_ransac {

namespace {

const char kImuFrame[] = "/imu";  // leading slash: as in BagLayout::kTum

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

/// The samples, and at each image the place of the IMU on the camera.
void writeImu(const Scene& scene, int frames, BagWriter& bag) {
  const SceneOptions& options = scene.options();
  for (const ImuSample& sample : scene.imuSamples(frames)) bag.writeImu(toMessage(sample, options.imu));
  const Eigen::Translation3d offset(options.offset, 0, 0);
  const Eigen::Isometry3d imu_in_camera = (options.imu.camera_in_imu * offset).inverse();
  for (int i = 0; i < frames; ++i) bag.writeSensorPlace(scene.stamp(i), kImuFrame, imu_in_camera);
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
  if (scene.options().imu.rate > 0) writeImu(scene, frames, bag);
  bag.close();
}

}  // namespace gms_ransac
