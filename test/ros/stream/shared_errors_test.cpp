// Errors that all pairs share: alike in each axis of a pair, growing with the way, gone on the way back.
#include "stream/shared_errors.h"

#include <random>

#include <gtest/gtest.h>

#include "stream/odometry.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

constexpr double kShare = 0.01, kParallax = 0.05;

PairMotion motionWith(const Eigen::Vector3d& t, const Eigen::Vector3d& rotation) {
  PairMotion motion = {RelativePose(), 0.1};
  motion.current_in_reference.t = t;
  motion.current_in_reference.R = rotationFromVector(rotation);
  motion.shared = sharedErrors(kShare, motion.current_in_reference, kParallax);
  return motion;
}

const PairMotion kAhead = motionWith({0.2, -0.1, 1}, {0, 0, 0}), kCurve = motionWith({0, 0.1, 1}, {0.01, 0.1, 0});

Matrix6d covarianceOf(const SharedErrors& errors) { return errors * errors.transpose(); }

TEST(SharedErrors, OfAPairAreAShareOfItsMotion) {
  const double length = kCurve.current_in_reference.t.norm(), angle = std::hypot(0.01, 0.1),
               distance = length / kParallax;
  Matrix6d expected = Matrix6d::Zero();
  expected.diagonal().head<3>().setConstant(length * length + std::pow(distance * angle, 2));
  expected.diagonal().tail<3>().setConstant(angle * angle + kParallax * kParallax);
  EXPECT_TRUE(covarianceOf(kCurve.shared).isApprox(kShare * kShare * expected, 1e-9)) << covarianceOf(kCurve.shared);
  // Without parallax nothing is known of the distance: no figure is infinite.
  EXPECT_TRUE(sharedErrors(kShare, kCurve.current_in_reference, 0).allFinite());
  EXPECT_TRUE(sharedErrors(kShare, RelativePose(), kParallax).isZero());
}

TEST(SharedErrors, GrowWithTheWay) {
  MotionIntegrator odometry;
  for (int i = 0; i < 100; ++i) odometry.add(kAhead);
  const Matrix6d covariance = odometry.camera().pose_covariance;
  EXPECT_NEAR(std::sqrt(covariance(4, 4)), 100 * kShare * kParallax, 1e-9);
  // Along the way there is the length alone; across it the rotation, added up, as well.
  const Eigen::Vector3d along = kAhead.current_in_reference.t.normalized();
  const double way = 100 * kAhead.current_in_reference.t.norm();
  EXPECT_NEAR(std::sqrt(along.dot(covariance.topLeftCorner<3, 3>() * along)), kShare * way, 1e-6);
  EXPECT_GT(std::sqrt(covariance(0, 0)), 1.5 * kShare * way);
  EXPECT_NEAR(std::sqrt(odometry.camera().twist_covariance(4, 4)), kShare * kParallax / 0.1, 1e-9);
}

TEST(SharedErrors, AreGoneOnTheWayBack) {
  MotionIntegrator odometry;
  const PairMotion back = motionWith(-kAhead.current_in_reference.t, {0, 0, 0});
  for (int i = 0; i < 10; ++i) odometry.add(kAhead);
  const Vector6d there = odometry.camera().pose_covariance.diagonal();
  for (int i = 0; i < 10; ++i) odometry.add(back);
  const Vector6d home = odometry.camera().pose_covariance.diagonal();
  // A remainder stays, because the rotation of a step counts from the next one on.
  for (int i = 0; i < 6; ++i) EXPECT_LT(home(i), 0.01 * there(i)) << i;
}

TEST(SharedErrors, CovarianceOfACurveAgreesWithMonteCarlo) {
  constexpr int kSteps = 20, kRuns = 4000;
  MotionIntegrator exact;
  for (int i = 0; i < kSteps; ++i) exact.add(kCurve);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Matrix6d sum = Matrix6d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    Eigen::Matrix<double, SharedErrors::ColsAtCompileTime, 1> size;
    for (int i = 0; i < size.size(); ++i) size[i] = normal(random);
    const Vector6d error = kCurve.shared * size;
    PairMotion wrong = kCurve;
    wrong.current_in_reference.t += error.head<3>();
    wrong.current_in_reference.R = rotationFromVector(error.tail<3>()) * wrong.current_in_reference.R;
    MotionIntegrator odometry;
    for (int i = 0; i < kSteps; ++i) odometry.add(wrong);
    Vector6d difference;
    difference << odometry.camera().pose.translation() - exact.camera().pose.translation(),
        rotationVector(odometry.camera().pose.linear() * exact.camera().pose.linear().transpose());
    sum += difference * difference.transpose() / kRuns;
  }
  // So many runs know a standard deviation to a per cent, a covariance to two or three.
  EXPECT_LT((sum - exact.camera().pose_covariance).norm(), 0.08 * sum.norm());
}

TEST(SharedErrors, BeginAnewWithAPoseThatIsSet) {
  MotionIntegrator odometry;
  for (int i = 0; i < 10; ++i) odometry.add(kCurve);
  odometry.set(Eigen::Isometry3d::Identity(), Matrix6d::Zero());
  odometry.add(kCurve);
  EXPECT_TRUE(odometry.camera().pose_covariance.isApprox(covarianceOf(kCurve.shared), 1e-3));
}

}  // namespace
}  // namespace gms_ransac
