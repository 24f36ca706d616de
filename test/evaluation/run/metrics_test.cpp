// The figures of merit against values worked out by hand.
#include "run/metrics.h"

#include <cmath>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

TEST(Metrics, PercentilesInterpolate) {
  EXPECT_DOUBLE_EQ(median({3, 1, 2, 10}), 2.5);
  EXPECT_DOUBLE_EQ(percentile({0, 10}, 90), 9);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(Metrics, PoseErrorSeparatesRotationAndDirection) {
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix();
  truth.translation() = Eigen::Vector3d(0, 0, 2.5);
  const Eigen::Matrix3d R = truth.linear() * Eigen::AngleAxisd(M_PI / 90, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const PoseError error = poseError(truth, R, Eigen::Vector3d(0, 1, 1));
  EXPECT_NEAR(error.rotation, 2, 1e-9);
  EXPECT_NEAR(error.direction, 45, 1e-6);
  EXPECT_NEAR(poseError(truth, R, Eigen::Vector3d(0, 0, -1)).direction, 180, 1e-5) << "the sign counts";
  EXPECT_DOUBLE_EQ(poseError(truth, R, Eigen::Vector3d::Zero()).direction, 90);
}

}  // namespace
}  // namespace gms_ransac
