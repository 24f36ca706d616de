// Gyro rates against the rotations that images see, on exact motions: integration, bias, contradictions and time
// offset.
#include "priors/rotation_comparison.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "datasets/dataset.h"
#include "past/standstill.h"
#include "priors/gyro_bias.h"
#include "priors/motion_track.h"
#include "priors/wheel_check.h"
#include "processor_stream.h"
#include "says.h"
#include "scenes/two_view_scene.h"
#include "shared_data.h"
#include "stream/odometry.h"
#include "support/random.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kGyroRate = 200, kFrame = 1 / 30.0;

/// A hand that shakes: no axis is like another.
Vector3d rateOf(double stamp) {
  return {0.8 * std::sin(5.1 * stamp), 0.6 * std::cos(3.3 * stamp + 1), 0.4 * std::sin(7.7 * stamp + 2)};
}

/// The true rotation, integrated a hundred times as finely.
Matrix3d rotationBetween(double from, double to) {
  constexpr int kSteps = 200;
  Matrix3d R = Matrix3d::Identity();
  const double step = (to - from) / kSteps;
  for (int i = 0; i < kSteps; ++i) R = R * rotationFromVector(step * rateOf(from + (i + 0.5) * step));
  return R;
}

GyroTrack gyroOf(double seconds, const Vector3d& bias = Vector3d::Zero(), double delay = 0, double amount = 1) {
  GyroTrack gyro;
  for (int i = 0; i < seconds * kGyroRate; ++i) {
    const double stamp = i / kGyroRate;
    gyro.add(stamp + delay, amount * rateOf(stamp) + bias, 1e-6);
  }
  return gyro;
}

TEST(MotionTrack, BeginsAnewWhereTheClockWasSetBack) {
  GyroTrack gyro;
  const auto send = [&](double from, double to, double rate) {
    for (int i = 0; from + i / kGyroRate < to; ++i) gyro.add(from + i / kGyroRate, {rate, 0, 0}, 1e-6);
  };
  send(10, 12, 1);
  send(11.7, 12.5, 0);  // set back by 0.3 s, and the camera stands from then on
  TrackMotion motion;
  ASSERT_EQ(gyro.between(11.8, 11.9, motion), "");
  EXPECT_LT(rotationVector(motion.motion.linear()).norm(), 1e-9) << "the rotation of before the step";
  EXPECT_NE(gyro.between(11.5, 11.9, motion), "") << "no motion spans it";
}

TEST(MotionTrack, OneSampleThatIsLateEndsNothing) {
  GyroTrack gyro;
  for (int i = 0; i < 400; ++i) {
    gyro.add(10 + i / kGyroRate, {1, 0, 0}, 1e-6);
    if (i % 50 == 10) gyro.add(10 + (i - 2) / kGyroRate, {1, 0, 0}, 1e-6);
  }
  TrackMotion motion;
  EXPECT_EQ(gyro.between(10, 11.9, motion), "");
}

TEST(MotionTrack, SaysWhatItDoesNotUse) {
  GyroTrack gyro;
  EXPECT_TRUE(gyro.add(1, {0, 0, 1}, 0));
  EXPECT_FALSE(gyro.add(2, {0, std::nan(""), 1}, 0));
  EXPECT_FALSE(gyro.add(std::nan(""), {0, 0, 1}, 0));
  OdometryTrack wheels;
  OdometrySample sample;
  EXPECT_TRUE(wheels.add(sample));
  sample.velocity.x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(wheels.add(sample));
}

TEST(RotationComparison, ClaimsNoAgreementBeforeItCanTell) {
  RotationComparison comparison;
  EXPECT_EQ(comparison.agreement(), "nothing compared yet");
  ComparedRotation pair;
  pair.visual = {0.1, 0, 0};  // the other sensor says that there was none
  pair.covariance = 1e-6 * Matrix3d::Identity();
  const auto add = [&](size_t until) {
    for (; comparison.pairs() < until; pair.from += 1) comparison.add(pair);
  };
  add(5);
  EXPECT_TRUE(says(comparison.agreement(), {"too few pairs to judge: 5 of 5 contradict"}));
  add(RotationComparison::kFewest - 1);
  EXPECT_EQ(comparison.agreement().find("agrees"), std::string::npos);
  add(RotationComparison::kFewest);
  EXPECT_TRUE(says(comparison.doubt(std::nullopt), {"contradicts the images in 100 % of the last 30 pairs"}));
  pair.prior = pair.visual;
  add(RotationComparison::kPairs);
  EXPECT_TRUE(says(comparison.agreement(), {"agrees with the images in 70 of the last 100 pairs"}));
}

TEST(GyroTrack, IntegratesTheRotationOfTheCamera) {
  const GyroTrack gyro = gyroOf(2);
  for (const double from : {0.0, 0.5, 1.2345}) {
    for (const double seconds : {0.001, 0.0333, 0.5}) {
      TrackMotion rotation;
      ASSERT_EQ(gyro.between(from, from + seconds, rotation), "");
      const Matrix3d truth = rotationBetween(from, from + seconds);
      // Between samples the rate counts as even: a sample's change of rate over an eighth of its time.
      EXPECT_LT(rotationVector(rotation.motion.linear().transpose() * truth).norm(), 1e-4 * seconds + 3e-5);
      EXPECT_NEAR(rotation.variance, seconds / kGyroRate * 1e-6, 1e-12);
    }
  }
}

TEST(GyroTrack, SaysWhatIsMissing) {
  GyroTrack gyro;
  TrackMotion rotation;
  EXPECT_EQ(gyro.between(0, 1, rotation), "no two samples have come");
  gyro.add(1, Vector3d::Zero(), 0);
  EXPECT_NE(gyro.between(0.9, 1, rotation), "");
  EXPECT_NE(gyro.between(1, 1, rotation), "");
  gyro.add(1.05, Vector3d::Zero(), 0);
  EXPECT_EQ(gyro.between(1, 1.05, rotation), "");
  EXPECT_EQ(gyro.between(1, 1.25, rotation), "the newest sample is 0.2 s too old");
  EXPECT_EQ(gyro.between(0.5, 1.05, rotation), "the samples start 0.5 s later");
  gyro.add(1.3, Vector3d::Zero(), 0);
  EXPECT_EQ(gyro.between(1, 1.25, rotation), "no sample came for 0.25 s between them");
}

TEST(GyroTrack, KeepsABoundedNumberOfSamples) {
  GyroTrack gyro;
  const size_t most = MotionTrack::kMostSamples;
  for (size_t i = 0; i < most + 10; ++i) gyro.add(100 + 1e-6 * static_cast<double>(i), Vector3d::Zero(), 0);
  EXPECT_EQ(gyro.samples(), most);
  TrackMotion rotation;
  EXPECT_EQ(gyro.between(100.01, 100.05, rotation), "");
}

TEST(GyroTrack, LeavesOutWhatIsLateAndStartsAnewWhereTheStreamDoes) {
  GyroTrack gyro = gyroOf(2);
  gyro.add(1.9, Vector3d(100, 0, 0), 0);
  gyro.add(3, Vector3d(NAN, 0, 0), 0);
  gyro.add(3, Vector3d(1e300, 0, 0), 0);  // the mean of two such rates is infinite
  TrackMotion rotation;
  ASSERT_EQ(gyro.between(1.8, 1.95, rotation), "");
  EXPECT_LT(rotationVector(rotation.motion.linear().transpose() * rotationBetween(1.8, 1.95)).norm(), 1e-4);
  EXPECT_FALSE(gyro.reaches(2.5));
  gyro.add(0.2, Vector3d::Zero(), 0);
  EXPECT_FALSE(gyro.reaches(1));
  EXPECT_TRUE(gyro.reaches(0.2));
}

ComparedRotation observation(double from, double to, const Vector3d& gyro_rate, const Vector3d& visual_rate) {
  return {from, to, (to - from) * visual_rate, (to - from) * gyro_rate, 25e-8 * Matrix3d::Identity()};
}

TEST(GyroBias, IsFoundAtRest) {
  const Vector3d bias(0.02, -0.03, 0.01);
  Random random(3);
  GyroBias filter;
  EXPECT_FALSE(filter.known());
  for (int i = 0; i < 60; ++i) {
    const Vector3d noise(gaussian(random), gaussian(random), gaussian(random));
    filter.add(observation(i * kFrame, (i + 1) * kFrame, bias, 5e-4 / kFrame * noise));
  }
  ASSERT_TRUE(filter.known());
  const Vector3d error = filter.bias() - bias;
  EXPECT_LT(error.norm(), 0.01);
  EXPECT_LT(error.squaredNorm() / filter.variance(), 14) << "beyond chance of one in a thousand";
}

TEST(GyroBias, LearnsNothingFromRotations) {
  GyroBias filter;
  for (int i = 0; i < 60; ++i) {
    filter.add(observation(i * kFrame, (i + 1) * kFrame, {0.5, 0.2, 0}, {0.4, 0.2, 0}));
  }
  EXPECT_FALSE(filter.known());
  EXPECT_EQ(filter.bias(), Vector3d::Zero());
}

TEST(GyroBias, CountsAHeldReferenceOnce) {
  GyroBias held, once;
  for (int i = 1; i <= 30; ++i) held.add(observation(0, i * kFrame, {0.01, 0, 0}, Vector3d::Zero()));
  once.add(observation(0, 30 * kFrame, {0.01, 0, 0}, Vector3d::Zero()));
  EXPECT_NEAR(held.variance(), once.variance(), 1e-12);
  EXPECT_LT((held.bias() - once.bias()).norm(), 1e-12);
}

/// The rotations that a camera in a shaking hand sees, and those that a gyro next to it measures.
struct Seen {
  RotationComparison comparison;
  GyroTrack gyro;
  Matrix3d gyro_axes;

  /// `axes`: what the gyro's axes are taken for.
  explicit Seen(const Matrix3d& axes, double delay = 0, const Vector3d& bias = Vector3d::Zero(), double amount = 1,
                double seconds = 4)
      : gyro(gyroOf(seconds + 1, bias, delay, amount)), gyro_axes(axes) {
    Random random(7);
    for (double from = 0.4; from + kFrame < seconds; from += kFrame) {
      const Vector3d noise(gaussian(random), gaussian(random), gaussian(random));
      const Vector3d visual = amount * rotationVector(rotationBetween(from, from + kFrame)) + 5e-4 * noise;
      const auto prior = (*this)(from, from + kFrame);
      if (prior) comparison.add({from, from + kFrame, visual, *prior, 1e-6 * Matrix3d::Identity()});
    }
  }
  std::optional<Vector3d> operator()(double from, double to) const {
    TrackMotion rotation;
    if (!gyro.between(from, to, rotation).empty()) return std::nullopt;
    return Vector3d(gyro_axes * rotationVector(rotation.motion.linear()));
  }
  std::optional<TimeOffset> offset() const { return comparison.timeOffset(*this); }
  std::string doubt() const { return comparison.doubt(offset()); }
};

TEST(RotationComparison, SaysNothingWhereBothAgree) {
  const Seen seen(Matrix3d::Identity());
  EXPECT_LT(seen.comparison.contradicting(), 0.05);
  EXPECT_EQ(seen.doubt(), "");
  ASSERT_TRUE(seen.offset());
  EXPECT_NEAR(seen.offset()->seconds, 0, 4 * seen.offset()->sigma);
  EXPECT_LT(seen.offset()->sigma, 0.002);
}

TEST(RotationComparison, FindsTheTimeOffset) {
  for (const Vector3d& bias : {Vector3d(0, 0, 0), Vector3d(0.05, -0.03, 0.02)}) {
    for (const double delay : {-0.12, -0.013, 0.004, 0.03, 0.15}) {
      const Seen seen(Matrix3d::Identity(), delay, bias);
      const auto offset = seen.offset();
      ASSERT_TRUE(offset) << delay;
      EXPECT_NEAR(offset->seconds, delay, 4 * offset->sigma + 1e-4) << delay;
      EXPECT_LT(offset->sigma, 0.002);
      EXPECT_TRUE(offset->explains);
      if (std::abs(delay) < 0.02) continue;
      EXPECT_TRUE(says(seen.doubt(), {"time offset"}));
    }
  }
}

TEST(RotationComparison, SaysWhatExplainsAContradiction) {
  Matrix3d axes;
  axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // the gyro's x ahead, y left, z up taken for the camera's x, y, z
  const struct {
    Matrix3d axes;
    std::vector<std::string> words;
  } rows[] = {// The camera's x by tf is its z: camera x = -(its y by tf).
              {axes, {"axes explain it", "(-y, -z, x)"}},
              // 0.4 rad are 22.9 degrees.
              {rotationFromVector({0, 0, 0.4}), {"extrinsics explain it", ", -23."}},
              {57.3 * Matrix3d::Identity(), {"neither"}}};
  for (const auto& row : rows) EXPECT_TRUE(says(Seen(row.axes).doubt(), row.words));
}

TEST(RotationComparison, OfRotationsAboutOneAxisOnlyThatAxisIsNamed) {
  RotationComparison comparison;
  for (int i = 0; i < 40; ++i) {
    const Vector3d yaw(0, 0.02 * std::sin(i), 0);
    comparison.add({i * kFrame, (i + 1) * kFrame, yaw, -yaw, 1e-6 * Matrix3d::Identity()});
  }
  EXPECT_TRUE(says(comparison.doubt(std::nullopt), {"(x, -y, z)"}));
}

TEST(RotationComparison, GivesNoOffsetWithoutRotationOrPairs) {
  const Seen still(Matrix3d::Identity(), 0.03, Vector3d::Zero(), 1e-3),
      early(Matrix3d::Identity(), 0.1, Vector3d::Zero(), 1, 1);
  for (const Seen* seen : {&still, &early}) {
    EXPECT_FALSE(seen->offset());
    EXPECT_EQ(seen->doubt(), "");
  }
}

OdometrySample wheels(double stamp, const Vector3d& position, double yaw, const Vector3d& velocity, double yaw_rate) {
  OdometrySample sample;
  sample.stamp = stamp;
  sample.pose.translation() = position;
  sample.pose.linear() = rotationFromVector({0, 0, yaw});
  sample.velocity = velocity;
  sample.angular = {0, 0, yaw_rate};
  return sample;
}

TEST(OdometryTrack, InterpolatesPoses) {
  OdometryTrack track;
  for (int i = 0; i < 20; ++i) track.add(wheels(0.1 * i, {0.1 * i, 0, 0}, 0, {1, 0, 0}, 0));
  TrackMotion motion;
  ASSERT_EQ(track.between(0.33, 1.07, motion), "");
  EXPECT_LT((motion.motion.translation() - Vector3d(0.74, 0, 0)).norm(), 1e-9);
  EXPECT_NE(track.between(0.33, 2.07, motion), "");
}

TEST(OdometryTrack, IntegratesATwistWithoutPoses) {
  OdometryTrack track;
  constexpr double kYawRate = 0.5, kSpeed = 1.2;
  for (int i = 0; i < 100; ++i) track.add(wheels(0.02 * i, Vector3d::Zero(), 0, {kSpeed, 0, 0}, kYawRate));
  TrackMotion motion;
  ASSERT_EQ(track.between(0.205, 1.205, motion), "");
  const double yaw = kYawRate, radius = kSpeed / kYawRate;
  EXPECT_LT((motion.motion.translation() - radius * Vector3d(std::sin(yaw), 1 - std::cos(yaw), 0)).norm(), 1e-4);
  EXPECT_LT(rotationVector(motion.motion.linear().transpose() * rotationFromVector({0, 0, yaw})).norm(), 1e-9);
}

RobustResult seenWith(double parallax, bool observable = true) {
  RobustResult seen;
  seen.judgement.pose_found = true;
  seen.judgement.translation_observable = observable;
  seen.judgement.pose.t = {0, 0, 1};
  seen.judgement.median_parallax_px = parallax;
  seen.judgement.sigma_px = 0.3;
  return seen;
}

TEST(WheelCheck, BelievesWheelsThatRollAndGetsUsedToAnotherDepth) {
  WheelCheck check;
  for (int i = 0; i < 40; ++i) {
    const double length = 0.05 + 0.001 * i;
    EXPECT_EQ(check.judge({0, 0, length}, seenWith(400 * length)), "") << i;
  }
  for (int i = 0; i < 30; ++i) check.judge({0, 0, 0.05}, seenWith(2));
  EXPECT_EQ(check.judge({0, 0, 0.05}, seenWith(2)), "");
}

TEST(WheelCheck, NoticesWheelsThatStandSpinSlideOrGoElsewhere) {
  WheelCheck check;
  EXPECT_TRUE(says(check.judge({0, 0, 0}, seenWith(5)), {"slip"}));
  EXPECT_TRUE(says(check.judge({0, 0, -0.05}, seenWith(5)), {"180 degrees"}));
  for (int i = 0; i < 20; ++i) check.judge({0, 0, 0.05}, seenWith(5));
  EXPECT_TRUE(says(check.judge({0, 0, 0.05}, seenWith(0.2, false)), {"slip"})) << "spinning on the spot";
  EXPECT_TRUE(says(check.judge({0, 0, 0.01}, seenWith(20)), {"slip"})) << "sliding";
  EXPECT_EQ(check.judge({0, 0, 0.05}, seenWith(6)), "");
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
  Vector3d mean = Vector3d::Zero();  // of the rates, which is the bias
  const auto rates = numbersIn(folder + "/imu.txt");
  for (const std::vector<double>& row : rates) {
    gyro.add(row[0], {row[1], row[2], row[3]}, 0);
    mean += Vector3d(row[1], row[2], row[3]) / static_cast<double>(rates.size());
  }
  GyroBias bias;
  MotionIntegrator odometry;
  const auto& frames = dataset->frames();
  ImageStream stream(ScaleMode::kUnit, *dataset->intrinsics(), {}, 1, frames[1].stamp - frames[0].stamp);
  int learnt = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const ProcessedFrame processed = stream.process(dataset->image(static_cast<int>(i)));
    if (i == 0) continue;
    ASSERT_TRUE(processed.poseValid()) << i << ": " << processed.text;
    const RelativePose& pose = processed.pair->result.robust.judgement.pose;
    const double seconds = stream.stamp() - processed.pair->reference->stamp(), from = frames[i].stamp - seconds;
    TrackMotion rotation;
    if (gyro.between(from, frames[i].stamp, rotation).empty()) {
      bias.add({from, frames[i].stamp, camera_in_imu * rotationVector(pose.R), rotationVector(rotation.motion.linear()),
                rotation.variance * Matrix3d::Identity() +
                    camera_in_imu * pose.covariance.bottomRightCorner<3, 3>() * camera_in_imu.transpose()});
      ++learnt;
    }
    odometry.add({processed.pose, seconds, processed.status == MatchStats::OK, processed.reference_held,
                  processed.pair->result.robust.judgement.median_parallax_px});
  }
  ASSERT_GT(learnt, 20);
  ASSERT_TRUE(bias.known());
  const Vector3d error = bias.bias() - mean;
  RecordProperty("bias_error", std::to_string(error.norm()));
  RecordProperty("bias_sigma", std::to_string(std::sqrt(bias.variance())));
  EXPECT_LT(error.norm(), 0.1 * mean.norm());
  EXPECT_LT(error.squaredNorm() / bias.variance(), 11.34);
  const OdometryEstimate& end = odometry.camera();
  const Vector3d drift = rotationVector(end.pose.linear());
  RecordProperty("rotated_degrees", std::to_string(drift.norm() * 180 / 3.14159265358979323846));
  RecordProperty("moved", std::to_string(end.pose.translation().norm()));
  // The vehicle vibrates by as much as the view of one at rest may move.
  const double vibration = kMostDrift / dataset->intrinsics()->fx;
  const Matrix3d covariance =
      end.pose_covariance.bottomRightCorner<3, 3>() + vibration * vibration * Matrix3d::Identity();
  EXPECT_LT(drift.dot(covariance.inverse() * drift), 11.34);
  const Vector3d moved = end.pose.translation();
  EXPECT_LT(moved.dot(end.pose_covariance.topLeftCorner<3, 3>().inverse() * moved), 11.34);
}

}  // namespace
}  // namespace gms_ransac
