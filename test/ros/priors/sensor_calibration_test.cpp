// Time offset, mounting and bias of a sensor, learnt from exact motions, from rendered images and from a real camera.
#include "priors/sensor_calibration.h"

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "datasets/dataset.h"
#include "past/standstill.h"
#include "processor_stream.h"
#include "says.h"
#include "scenes/scene.h"
#include "scenes/two_view_scene.h"
#include "shaking_hand.h"
#include "shared_data.h"
#include "stream/odometry.h"
#include "support/random.h"

namespace gms_ransac {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = 3.14159265358979323846 / 180, kNoise = 5e-4;
const Vector3d kMounting = kDegree * Vector3d(1.2, -1.4, 0.8);  // two degrees
constexpr double kBiasSigma = 0.05;

double rotationError(const Matrix3d& a, const Matrix3d& b) { return rotationVector(a.transpose() * b).norm(); }

SensorCalibration::RotationBetween rotationsOf(const GyroTrack& gyro, const Matrix3d& camera_in_imu) {
  return [&gyro, camera_in_imu](double from, double to) -> std::optional<RotationPrior> {
    TrackMotion rotation;
    if (!gyro.between(from, to, rotation).empty()) return std::nullopt;
    RotationPrior prior;
    prior.R = camera_in_imu.transpose() * rotation.motion.linear() * camera_in_imu;
    prior.covariance = rotation.variance * Matrix3d::Identity();
    return prior;
  };
}

/// All that is said for a calibration.
std::string foundBy(const SensorCalibration& calibration) {
  std::string all;
  for (const auto& [key, sentence] : calibration.found("/imu", 0.01)) all += sentence + "\n";
  return all;
}

/// A camera in a hand, and a gyro whose axes are taken for those of the camera.
struct Rig {
  SensorCalibration calibration{kBiasSigma};
  GyroTrack gyro;
  Vector3d mounting = Vector3d::Zero(), bias = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity();  ///< about which the camera rotates
  double delay = 0;
  double wrong = 0;  ///< share of pairs that are degrees off
  double stamp = 0.4, sampled = 0;
  Random random{7};

  Vector3d rate(double time) const { return axes * rateOf(time); }
  Matrix3d truth(double from) const {
    constexpr int kSteps = 20;
    Matrix3d R = Matrix3d::Identity();
    const double step = kFrame / kSteps;
    for (int i = 0; i < kSteps; ++i) R = R * rotationFromVector(step * rate(from + (i + 0.5) * step));
    return R;
  }
  void see(int pairs) {
    for (int i = 0; i < pairs; ++i, stamp += kFrame) {
      for (; sampled + delay < stamp + kFrame + 0.1; sampled += 1 / kGyroRate) {
        gyro.add(sampled + delay, rotationFromVector(-mounting) * rate(sampled) + bias, 1e-6);
      }
      Vector3d noise(gaussian(random), gaussian(random), gaussian(random));
      if (random.uniform() < wrong) noise += Vector3d(60, -100, 40);
      calibration.add({stamp, stamp + kFrame, rotationVector(truth(stamp)) + kNoise * noise,
                       kNoise * kNoise * Matrix3d::Identity()},
                      rotationsOf(gyro, Matrix3d::Identity()));
    }
  }
  /// Of the rotations of the last second, degrees, root mean square.
  double error() const {
    double squares = 0;
    constexpr int kPairs = 30;
    for (double from = stamp - kFrame; from > stamp - (kPairs + 0.5) * kFrame; from -= kFrame) {
      const auto prior = calibration.correct(rotationsOf(gyro, Matrix3d::Identity()), from, from + kFrame);
      const double error = prior ? rotationError(prior->R, truth(from)) / kDegree : 180;
      squares += error * error / kPairs;
    }
    return std::sqrt(squares);
  }
};

TEST(SensorCalibration, FindsTimeOffsetAndMounting) {
  for (const double delay : {0.0, 0.005, -0.023, 0.023, -0.08, 0.08}) {
    for (const Vector3d& mounting : {Vector3d(0, 0, 0), kMounting}) {
      for (const double wrong : {0.0, 0.1}) {
        Rig rig;
        rig.delay = delay;
        rig.mounting = mounting;
        rig.bias = {0.02, -0.03, 0.01};
        rig.wrong = wrong;
        rig.see(100);
        EXPECT_LT(rig.error(), 0.015) << delay;
        rig.see(200);
        EXPECT_LT(rig.error(), 0.01) << delay;
        EXPECT_NEAR(rig.calibration.timeOffset(), delay, 0.001);
        const std::string found = foundBy(rig.calibration);
        std::vector<std::string> words;
        if (delay != 0) words = {"the stamps of /imu are 0.0", delay > 0 ? "late" : "early"};
        if (!mounting.isZero()) words.emplace_back("rotate the camera in tf by (-1.");
        EXPECT_TRUE(says(found, words)) << delay;
      }
    }
  }
}

TEST(SensorCalibration, KnowsNothingWithoutRotation) {
  Rig rig;
  rig.axes.setZero();
  rig.delay = 0.08;
  rig.mounting = kMounting;
  rig.bias = {0.02, -0.03, 0.01};
  rig.see(600);
  EXPECT_NEAR(rig.calibration.timeOffset(), 0, 1e-9);
  EXPECT_EQ(foundBy(rig.calibration), "");
  EXPECT_LT(rig.error(), 0.01) << "less the bias";
}

TEST(SensorCalibration, LearnsNothingOfTheAxisOfAllRotations) {
  Rig rig;
  rig.axes = Vector3d::UnitY() * Eigen::RowVector3d(1, 0, 0);
  rig.mounting = kMounting;
  rig.see(600);
  const auto prior = rig.calibration.correct(
      [](double, double) {
        RotationPrior prior;
        prior.R = rotationFromVector({0, 0, 0.1});
        return prior;
      },
      1, 1 + kFrame);
  ASSERT_TRUE(prior);
  // A rotation about z moves by the mounting about x, which is known, and not by that about y.
  const Vector3d moved = rotationVector(prior->R) - Vector3d(0, 0, 0.1);
  EXPECT_NEAR(moved.y(), -0.1 * kMounting.x(), 3e-4);
  EXPECT_NEAR(moved.x(), 0, 3e-4);
  EXPECT_NEAR(std::sqrt(prior->covariance(0, 0)), 0.1 * 0.01, 1e-4) << "of a careful installation";
}

TEST(SensorCalibration, FollowsAKnockAndAClockThatSteps) {
  Rig knocked, stepped;
  for (Rig* rig : {&knocked, &stepped}) rig->see(250);
  knocked.mounting = kMounting;
  stepped.delay = 0.05;
  for (Rig* rig : {&knocked, &stepped}) {
    EXPECT_EQ(foundBy(rig->calibration), "");
    rig->see(200);
    EXPECT_LT(rig->error(), 0.02);
    EXPECT_NE(foundBy(rig->calibration), "");
  }
  EXPECT_NEAR(stepped.calibration.timeOffset(), 0.05, 0.002);
}

TEST(SensorCalibration, LeavesGrossErrorsToTheComparison) {
  for (const Vector3d& mounting : {Vector3d(0.4, 0, 0), Vector3d(0, 1.2, 0), Vector3d(1.2, 1.2, 1.2)}) {
    Rig rig;
    rig.mounting = mounting;
    for (int i = 0; i < 8; ++i) {
      rig.see(50);
      EXPECT_EQ(foundBy(rig.calibration), "") << mounting;
    }
  }
}

TEST(SensorCalibration, CountsAHeldReferenceOnce) {
  const auto sensor = [](double from, double to) {
    RotationPrior prior;
    prior.R = rotationFromVector({0.01 * (to - from), 0, 0});
    return prior;
  };
  SensorCalibration held(kBiasSigma), once(kBiasSigma);
  const Matrix3d covariance = 1e-6 * Matrix3d::Identity();
  for (int i = 1; i <= 30; ++i) held.add({1, 1 + i * kFrame, Vector3d::Zero(), covariance}, sensor);
  once.add({1, 1 + 30 * kFrame, Vector3d::Zero(), covariance}, sensor);
  const auto a = held.correct(sensor, 2, 3), b = once.correct(sensor, 2, 3);
  EXPECT_LT(rotationError(a->R, b->R), 1e-9);
  EXPECT_TRUE(a->covariance.isApprox(b->covariance, 1e-6));
}

/// A rendered room, seen by a hand. The gyro is late and mounted by two degrees otherwise than is known.
TEST(SensorCalibration, FindsWhatARenderedGyroHas) {
  constexpr int kFrames = 160;
  SceneOptions options;
  options.size = {320, 240};
  options.sway = 3;
  const Scene camera(options);
  std::vector<SeenRotation> pairs;
  ImageStream stream(ScaleMode::kUnit, camera.intrinsics(), {}, 1, kFrame);
  for (int i = 0; i < kFrames; ++i) {
    const ProcessedFrame processed = stream.process(camera.render(i).image);
    if (i == 0 || !processed.pair) continue;
    const Judgement& judgement = processed.pair->result.robust.judgement;
    if (!judgement.pose_found) continue;
    const double to = camera.stamp(i), from = to - (stream.stamp() - processed.pair->reference->stamp());
    pairs.push_back({from, to, rotationVector(judgement.pose.R), judgement.pose.covariance.bottomRightCorner<3, 3>()});
  }
  ASSERT_GT(pairs.size(), kFrames * 0.9);
  options.imu.rate = kGyroRate;
  for (const double delay : {0.005, 0.023, 0.08}) {
    options.imu.delay = delay;
    options.imu.camera_in_imu.linear() = rotationFromVector(-kMounting);
    GyroTrack gyro;
    for (const ImuSample& sample : Scene(options).imuSamples(kFrames + 10)) {
      gyro.add(sample.time, sample.angular_velocity, 0);
    }
    const auto sensor = rotationsOf(gyro, Matrix3d::Identity());
    SensorCalibration calibration(kBiasSigma);
    for (const SeenRotation& pair : pairs) calibration.add(pair, sensor);
    double before = 0, after = 0;
    for (int i = kFrames / 2; i + 1 < kFrames; ++i) {
      const double from = camera.stamp(i), to = camera.stamp(i + 1);
      const Matrix3d truth = camera.pose(i).linear().transpose() * camera.pose(i + 1).linear();
      const auto corrected = calibration.correct(sensor, from, to);
      ASSERT_TRUE(corrected);
      before = std::max(before, rotationError(sensor(from, to)->R, truth));
      after = std::max(after, rotationError(corrected->R, truth));
    }
    const std::string name = "late_" + std::to_string(std::lround(1000 * delay)) + "_ms_";
    RecordProperty(name + "found", foundBy(calibration));
    RecordProperty(name + "degrees_before", std::to_string(before / kDegree));
    RecordProperty(name + "degrees_after", std::to_string(after / kDegree));
    EXPECT_NEAR(calibration.timeOffset(), delay, 0.004);
    EXPECT_LT(after, 0.3 * before) << delay;
    EXPECT_TRUE(says(foundBy(calibration), {"late", "rotate the camera in tf by (-1."}));
  }
}

/// The numbers of the lines of a file that are no comments.
std::vector<std::vector<double>> numbersIn(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream text(line);
    const std::vector<double> row{std::istream_iterator<double>(text), {}};
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

/// EuRoC V1_01 from its start: a vehicle that stands still, its images and its gyro.
TEST(StandingStill, FindsTheBiasAndDoesNotDrift) {
  OPEN_OR_SKIP(dataset, "euroc_v101");
  const std::string folder = (dataFolder() / "euroc_v101").string();
  const auto mount = numbersIn(folder + "/camera_in_imu.txt");
  ASSERT_EQ(mount.size(), 4u);
  Matrix3d camera_in_imu;
  for (size_t i = 0; i < 3; ++i) camera_in_imu.row(i) = Eigen::Map<const Eigen::RowVector3d>(mount[i].data());
  GyroTrack gyro;
  for (const auto& row : numbersIn(folder + "/imu.txt")) gyro.add(row[0], {row[1], row[2], row[3]}, 0);
  SensorCalibration calibration(kBiasSigma);
  MotionIntegrator odometry;
  const auto& frames = dataset->frames();
  ImageStream stream(ScaleMode::kUnit, *dataset->intrinsics(), {}, 1, frames[1].stamp - frames[0].stamp);
  for (size_t i = 0; i < frames.size(); ++i) {
    const ProcessedFrame processed = stream.process(dataset->image(static_cast<int>(i)));
    if (i == 0) continue;
    ASSERT_TRUE(processed.poseValid()) << i << ": " << processed.text;
    const RelativePose& pose = processed.pair->result.robust.judgement.pose;
    const double seconds = stream.stamp() - processed.pair->reference->stamp(), from = frames[i].stamp - seconds;
    calibration.add({from, frames[i].stamp, rotationVector(pose.R), pose.covariance.bottomRightCorner<3, 3>()},
                    rotationsOf(gyro, camera_in_imu));
    odometry.add({processed.pose, seconds, processed.status == MatchStats::OK, processed.reference_held,
                  processed.pair->result.robust.judgement.median_parallax_px});
  }
  // The vehicle vibrates by as much as the view of one at rest may move.
  const double vibration = kMostDrift / dataset->intrinsics()->fx;
  const Matrix3d vibrates = vibration * vibration * Matrix3d::Identity();
  EXPECT_EQ(foundBy(calibration), "");
  const double end_stamp = frames.back().stamp - 0.1;
  const auto corrected = calibration.correct(rotationsOf(gyro, camera_in_imu), end_stamp - 0.5, end_stamp);
  const auto biased = rotationsOf(gyro, camera_in_imu)(end_stamp - 0.5, end_stamp);
  ASSERT_TRUE(corrected);
  const Vector3d left = rotationVector(corrected->R);
  EXPECT_LT(left.dot((corrected->covariance + vibrates).inverse() * left), 11.34);
  EXPECT_LT(left.norm(), 0.1 * rotationVector(biased->R).norm());
  const OdometryEstimate& end = odometry.camera();
  const Vector3d drift = rotationVector(end.pose.linear());
  RecordProperty("rotated_degrees", std::to_string(drift.norm() * 180 / 3.14159265358979323846));
  RecordProperty("moved", std::to_string(end.pose.translation().norm()));
  const Matrix3d covariance = end.pose_covariance.bottomRightCorner<3, 3>() + vibrates;
  EXPECT_LT(drift.dot(covariance.inverse() * drift), 11.34);
  const Vector3d moved = end.pose.translation();
  EXPECT_LT(moved.dot(end.pose_covariance.topLeftCorner<3, 3>().inverse() * moved), 11.34);
}

}  // namespace
}  // namespace gms_ransac
