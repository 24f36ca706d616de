// Poses chained over fifty images: their covariance against their errors, where the truth is exact.
#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "drive_scene.h"
#include "scale/translation_scale.h"
#include "stream/odometry.h"

namespace gms_ransac {
namespace {

constexpr int kImages = 50, kChains = 12;
constexpr double kSecondsApart = 0.1;

/// Half a metre ahead, with a rotation of a degree.
const Eigen::Isometry3d kStep = makeStep({0.05, 0, 0.5}, {0, M_PI / 180, 0});

/// Normalised estimation error squared over degrees of freedom, mean over chains: 1 where the covariance is true.
struct Nees {
  double rotation = 0, position = 0;
};

double neesOf(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.ldlt().solve(error)) / 3;
}

Nees neesOfChains(bool keypoints_stay) {
  Nees mean;
  RobustResult result;
  for (int chain = 0; chain < kChains; ++chain) {
    Drive drive(static_cast<uint64_t>(chain) + 1, kStep, keypoints_stay);
    const auto estimator = makeEstimator("lo_prosac", RobustOptions());
    MotionIntegrator odometry;
    odometry.restart();
    for (int i = 0; i < kImages; ++i) {
      estimator->estimate(drive.advance(), sceneCamera(), result);
      EXPECT_TRUE(result.judgement.translation_observable) << chain << " " << i;
      odometry.add({withLength(result.judgement.pose, {kStep.translation().norm(), 0, 1}), kSecondsApart});
    }
    const OdometryEstimate& estimate = odometry.camera();
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(estimate.pose.linear() * drive.pose().linear().transpose()));
    const Eigen::Vector3d shift = estimate.pose.translation() - drive.pose().translation();
    mean.rotation += neesOf(turn.angle() * turn.axis(), estimate.pose_covariance.bottomRightCorner<3, 3>()) / kChains;
    mean.position += neesOf(shift, estimate.pose_covariance.topLeftCorner<3, 3>()) / kChains;
  }
  return mean;
}

// Means of 36 squares, so they are known to a quarter.
TEST(ChainedPose, CovarianceGrowsAsTheErrorDoes) {
  const Nees nees = neesOfChains(false);
  EXPECT_GT(nees.rotation, 0.5);
  EXPECT_LT(nees.rotation, 2);
  // If a shift explains a pair's sideways rotation as well, its covariance is wider than its errors need.
  EXPECT_LT(nees.position, 2);
}

// The error of a keypoint in the shared image rotates one pair one way and the next the other way. The covariance of
// the chain takes these errors as independent.
TEST(ChainedPose, KeypointsThatPairsShareMakeItNoWorse) {
  const Nees shared = neesOfChains(true), fresh = neesOfChains(false);
  EXPECT_LT(shared.rotation, fresh.rotation);
  EXPECT_GT(shared.rotation, 0.1);
}

}  // namespace
}  // namespace gms_ransac
