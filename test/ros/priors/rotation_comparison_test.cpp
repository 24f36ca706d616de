// Rates of gyros and odometry of wheels against what images see, on exact motions: integration and contradictions.
#include "priors/rotation_comparison.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "priors/motion_track.h"
#include "priors/wheel_check.h"
#include "says.h"
#include "scenes/two_view_scene.h"
#include "shaking_hand.h"
#include "support/random.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

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
  EXPECT_TRUE(says(comparison.doubt(), {"contradicts the images in 100 % of the last 30 pairs"}));
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

/// The rotations that a camera in a shaking hand sees, and those of a gyro next to it whose axes are taken for others.
RotationComparison compared(const Matrix3d& axes) {
  const GyroTrack gyro = gyroOf(5);
  RotationComparison comparison;
  Random random(7);
  for (double from = 0.4; from + kFrame < 4; from += kFrame) {
    const Vector3d noise(gaussian(random), gaussian(random), gaussian(random));
    const Vector3d visual = rotationVector(rotationBetween(from, from + kFrame)) + 5e-4 * noise;
    TrackMotion rotation;
    if (!gyro.between(from, from + kFrame, rotation).empty()) continue;
    comparison.add(
        {from, from + kFrame, visual, axes * rotationVector(rotation.motion.linear()), 1e-6 * Matrix3d::Identity()});
  }
  return comparison;
}

TEST(RotationComparison, SaysNothingWhereBothAgree) {
  const RotationComparison comparison = compared(Matrix3d::Identity());
  EXPECT_LT(comparison.contradicting(), 0.05);
  EXPECT_EQ(comparison.doubt(), "");
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
  for (const auto& row : rows) EXPECT_TRUE(says(compared(row.axes).doubt(), row.words));
}

TEST(RotationComparison, OfRotationsAboutOneAxisOnlyThatAxisIsNamed) {
  RotationComparison comparison;
  for (int i = 0; i < 40; ++i) {
    const Vector3d yaw(0, 0.02 * std::sin(i), 0);
    comparison.add({i * kFrame, (i + 1) * kFrame, yaw, -yaw, 1e-6 * Matrix3d::Identity()});
  }
  EXPECT_TRUE(says(comparison.doubt(), {"(x, -y, z)"}));
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

}  // namespace
}  // namespace gms_ransac
