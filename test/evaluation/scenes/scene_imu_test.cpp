// The rendered camera's IMU: exact on motions that have a formula, integrates to the path, and has the noise asked for.
#include "scenes/scene_imu.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scenes/scene.h"

namespace gms_ransac {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

ImuOptions noiselessImu(double rate) {
  ImuOptions options;
  options.rate = rate;
  options.gyro_noise = options.accelerometer_noise = options.gyro_walk = options.accelerometer_walk = 0;
  return options;
}

TEST(SceneImu, MeasuresARotatingArmByItsFormula) {
  // The camera rotates about a vertical axis and looks outwards; the IMU is 0.3 m below it and 0.2 m farther out.
  const double omega = 2, radius = 1.5;
  const auto camera = [&](double t) -> Isometry3d {
    const Vector3d out(std::cos(omega * t), std::sin(omega * t), 0), down(0, 0, -1);
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() << down.cross(out), down, out;
    pose.translation() = radius * out;
    return pose;
  };
  ImuOptions options = noiselessImu(200);
  Isometry3d imu_in_camera = Isometry3d::Identity();
  imu_in_camera.translation() << 0, 0.3, 0.2;
  imu_in_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // its x is the camera's -y: up; y is -z: inwards
  options.camera_in_imu = imu_in_camera.inverse();
  const std::vector<ImuSample> samples = simulateImu(camera, 1, 2, options, 0);
  ASSERT_EQ(samples.size(), 201u);
  for (size_t i = 0; i < samples.size(); ++i) {
    EXPECT_NEAR(samples[i].time, 1 + i / 200.0, 1e-12);
    EXPECT_LT((samples[i].angular_velocity - imu_in_camera.linear().transpose() * Vector3d(0, -omega, 0)).norm(), 1e-6);
    const Vector3d force_in_camera(0, -kGravity, -omega * omega * (radius + 0.2));
    EXPECT_LT((samples[i].specific_force - imu_in_camera.linear().transpose() * force_in_camera).norm(), 1e-4);
  }
}

/// Integrates the samples by their means from a pose with its velocity; returns the last pose.
Isometry3d integrated(const std::vector<ImuSample>& samples, Isometry3d pose, Vector3d velocity) {
  for (size_t i = 0; i + 1 < samples.size(); ++i) {
    const double dt = samples[i + 1].time - samples[i].time;
    const Vector3d rotation = 0.5 * dt * (samples[i].angular_velocity + samples[i + 1].angular_velocity);
    const Matrix3d before = pose.linear();
    pose.linear() = before * Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
    const Vector3d acceleration =
        0.5 * (before * samples[i].specific_force + pose.linear() * samples[i + 1].specific_force) -
        kGravity * Vector3d::UnitZ();
    pose.translation() += dt * velocity + 0.5 * dt * dt * acceleration;
    velocity += dt * acceleration;
  }
  return pose;
}

TEST(SceneImu, IntegratesToThePathOfTheScene) {
  // The scene's own path, and a drawn one with 90 degrees a second.
  std::vector<StampedPose> poses;
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.01 * i;
    poses.push_back({t, Eigen::Translation3d(std::sin(t), 0.5 * std::sin(3 * t), 0.2 * std::cos(4 * t)) *
                            Eigen::AngleAxisd(1.4 * t, Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(2 + 0.3 * std::sin(2 * t), Vector3d::UnitX())});
  }
  SceneOptions own, along;
  along.trajectory = std::make_shared<Trajectory>(poses);
  for (SceneOptions options : {own, along}) {
    options.size = {64, 48};
    options.rate = 20;
    options.imu = noiselessImu(200);
    options.imu.camera_in_imu =
        Eigen::Translation3d(0.05, -0.02, 0.1) * Eigen::AngleAxisd(0.9, Vector3d(1, 2, 3).normalized());
    const Scene scene(options);
    const int frames = 160;
    const std::vector<ImuSample> samples = scene.imuSamples(frames);
    ASSERT_EQ(samples.size(), 10u * (frames + 1) + 1);
    EXPECT_NEAR(samples.front().time, scene.stamp(0) - 1 / options.rate, 1e-6);
    EXPECT_NEAR(samples.back().time, scene.stamp(frames - 1) + 1 / options.rate, 1e-6);
    // From the first image to the last: 7.95 s.
    const std::vector<ImuSample> between(samples.begin() + 10, samples.end() - 10);
    const Isometry3d imu_in_camera = options.imu.camera_in_imu.inverse();
    const auto imu_pose = [&](int frame) { return scene.pose(frame) * imu_in_camera; };
    // The velocity that leads to the place at the eleventh image, half a second later.
    const Isometry3d without_velocity =
        integrated({between.begin(), between.begin() + 101}, imu_pose(0), Vector3d::Zero());
    const Vector3d velocity = (imu_pose(10).translation() - without_velocity.translation()) / 0.5;
    const Isometry3d end = integrated(between, imu_pose(0), velocity), truth = imu_pose(frames - 1);
    EXPECT_LT((end.translation() - truth.translation()).norm(), 0.01);
    EXPECT_LT(Eigen::AngleAxisd(end.linear().transpose() * truth.linear()).angle(), 1e-3);
  }
}

TEST(SceneImu, HasTheNoiseAndTheDelayAskedFor) {
  const auto at_rest = [](double) -> Isometry3d { return Isometry3d::Identity(); };
  ImuOptions white = noiselessImu(200), walk = white;
  white.gyro_noise = 1.7e-4;
  white.accelerometer_noise = 2e-3;
  white.delay = 0.03;
  walk.gyro_walk = 1.9e-5;
  walk.accelerometer_walk = 3e-3;
  const auto deviation = [](const std::vector<double>& values) {
    double squared = 0;
    for (const double value : values) squared += value * value;
    return std::sqrt(squared / values.size());
  };
  std::vector<double> gyro, accelerometer;
  const std::vector<ImuSample> samples = simulateImu(at_rest, 0, 100, white, 0);
  for (const ImuSample& sample : samples) {
    for (int k = 0; k < 3; ++k) gyro.push_back(sample.angular_velocity[k]);
    for (int k = 0; k < 3; ++k) accelerometer.push_back(sample.specific_force[k] - (k == 2 ? kGravity : 0));
  }
  EXPECT_NEAR(deviation(gyro), 1.7e-4 * std::sqrt(200), 0.02 * 1.7e-4 * std::sqrt(200));
  EXPECT_NEAR(deviation(accelerometer), 2e-3 * std::sqrt(200), 0.02 * 2e-3 * std::sqrt(200));
  EXPECT_EQ(samples[0].time, 0.03);

  gyro.clear(), accelerometer.clear();
  for (uint64_t seed = 0; seed < 300; ++seed) {  // after 2 s a walk has sqrt(2) of its density
    const ImuSample last = simulateImu(at_rest, 0, 2, walk, seed).back();
    for (int k = 0; k < 3; ++k) gyro.push_back(last.angular_velocity[k]);
    for (int k = 0; k < 3; ++k) accelerometer.push_back(last.specific_force[k] - (k == 2 ? kGravity : 0));
  }
  EXPECT_NEAR(deviation(gyro), 1.9e-5 * std::sqrt(2), 0.1 * 1.9e-5 * std::sqrt(2));
  EXPECT_NEAR(deviation(accelerometer), 3e-3 * std::sqrt(2), 0.1 * 3e-3 * std::sqrt(2));
}

TEST(SceneImu, RepeatsWithTheSeedAndBelongsToBothCameras) {
  SceneOptions options;
  options.size = {64, 48};
  options.imu.rate = 100;
  const auto force = [](const SceneOptions& scene_options) {
    return Scene(scene_options).imuSamples(3)[7].specific_force;
  };
  const Vector3d first = force(options);
  EXPECT_EQ(force(options), first);
  SceneOptions other = options;
  other.seed = 1;
  EXPECT_NE(force(other), first);
  options.offset = 0.3;
  EXPECT_EQ(force(options), first);
  options.imu.rate = 0;
  EXPECT_TRUE(Scene(options).imuSamples(3).empty());
  options.imu.gyro_noise = -1;
  EXPECT_THROW(Scene{options}, std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
