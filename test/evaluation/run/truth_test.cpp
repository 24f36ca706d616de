// The truth that answers are compared with, and its noise, computed by hand.
#include "run/truth.h"

#include <cmath>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

constexpr double kDegree = M_PI / 180;

TEST(TruthNoise, AClockOffsetMovesTheTruthOneWay) {
  const ClockStep step = {Eigen::Vector3d(0, 0.2 * kDegree, 0), Eigen::Vector3d(0.03, 0, 0)};
  const PairNoise noise({}, step, Eigen::Isometry3d::Identity());
  EXPECT_NEAR(noise.rotation(1, 1), std::pow(0.2 * kDegree, 2), 1e-12);
  EXPECT_NEAR(noise.translation(0, 0), 0.0009, 1e-12);
  EXPECT_EQ(noise.rotation(0, 0) + noise.translation(1, 1), 0);
}

TEST(TruthNoise, RotatedAxesRotateTheDirectionAndLittleOfTheRotation) {
  TruthNoise axes;
  axes.alignment = 0.2 * kDegree;
  Eigen::Isometry3d truth(Eigen::AngleAxisd(kDegree, Eigen::Vector3d::UnitZ()));
  truth.translation().z() = 5;
  const PairNoise noise(axes, {}, truth);
  EXPECT_NEAR(std::sqrt(noise.translation(0, 0)), 5 * 0.2 * kDegree, 1e-9) << "whatever the length";
  EXPECT_NEAR(noise.translation(2, 2), 0, 1e-12);
  EXPECT_NEAR(std::sqrt(noise.rotation(1, 1)), kDegree * 0.2 * kDegree, 1e-9);
  EXPECT_NEAR(noise.rotation(2, 2), 0, 1e-12);
}

TEST(TruthNoise, ABaselineOfTenDeviationsHasADirection) {
  TruthNoise noise;
  EXPECT_FALSE(hasMoved(0, noise));
  EXPECT_TRUE(hasMoved(0.001, noise));
  noise.translation = 0.005;
  EXPECT_FALSE(hasMoved(0.049, noise));
  EXPECT_TRUE(hasMoved(0.051, noise));
}

TEST(PairTruth, PoseErrorSeparatesRotationAndDirection) {
  Eigen::Isometry3d truth(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  truth.translation() = Eigen::Vector3d(0, 0, 2.5);
  const Eigen::Matrix3d R = truth.linear() * Eigen::AngleAxisd(M_PI / 90, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const PoseError error = poseError(truth, R, Eigen::Vector3d(0, 1, 1));
  EXPECT_NEAR(error.rotation, 2, 1e-9);
  EXPECT_NEAR(error.direction, 45, 1e-6);
  EXPECT_NEAR(poseError(truth, R, Eigen::Vector3d(0, 0, -1)).direction, 180, 1e-5) << "the sign counts";
  EXPECT_DOUBLE_EQ(poseError(truth, R, Eigen::Vector3d::Zero()).direction, 90);
}

TEST(TruthNoise, FollowsTheKindOfSet) {
  EXPECT_GT(defaultTruthNoise("/data/7scenes_redkitchen/").translation, defaultTruthNoise("tum_fr1_desk").translation);
  EXPECT_TRUE(defaultTruthNoise("rendered_street").exact());
  EXPECT_GT(defaultTruthNoise("my_KITTI_07").rotation, 0);
}

}  // namespace
}  // namespace gms_ransac
