// Chained poses against exact ones, and their covariance against a Monte Carlo run.
#include "stream/odometry.h"

#include <gtest/gtest.h>

#include <random>

namespace gms_ransac {
namespace {

RelativePose motion(const Eigen::Vector3d& t, const Eigen::Vector3d& rotation) {
  RelativePose pose;
  pose.t = t;
  pose.R = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  return pose;
}

const RelativePose kStep = motion({0.3, -0.1, 0.8}, {0.02, 0.2, -0.05});

/// Ahead of the base, looking along base x (optical axes).
const Eigen::Isometry3d kCameraInBase = Eigen::Translation3d(0.5, 0.1, 0.2) * Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);

TEST(MotionIntegrator, ChainsMotions) {
  MotionIntegrator odometry;
  Eigen::Isometry3d expected = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 10; ++i) {
    odometry.add({kStep, 0.1});
    expected = expected * toIsometry(kStep);
  }
  EXPECT_TRUE(odometry.camera().pose.isApprox(expected, 1e-12));
}

TEST(MotionIntegrator, AHeldReferenceIsNotLeft) {
  MotionIntegrator odometry;
  odometry.add({kStep, 0.1});
  odometry.add({motion({0, 0, 0}, {0, 0.1, 0}), 0.1, false, true});
  odometry.add({kStep, 0.2});
  EXPECT_TRUE(odometry.camera().pose.isApprox(toIsometry(kStep) * toIsometry(kStep), 1e-12));
}

TEST(MotionIntegrator, WithoutMetresTheRotationStaysAsGood) {
  OdometryEstimate estimate;
  estimate.pose_covariance = estimate.twist_covariance = Matrix6d::Constant(0.01) + 0.03 * Matrix6d::Identity();
  const OdometryEstimate before = estimate;
  forgetLength(false, estimate);
  for (const Matrix6d& covariance : {estimate.pose_covariance, estimate.twist_covariance}) {
    EXPECT_EQ(covariance.topLeftCorner(3, 3), 1e6 * Eigen::Matrix3d::Identity());
    EXPECT_EQ(covariance.topRightCorner(3, 3), Eigen::Matrix3d::Zero());
    EXPECT_EQ(covariance.bottomRightCorner(3, 3), before.pose_covariance.bottomRightCorner(3, 3));
  }
}

TEST(MotionIntegrator, RestIsNoMeasureOfUsualMotions) {
  MotionIntegrator odometry;
  odometry.add({kStep, 0.1});
  const double step = odometry.step();
  PairMotion rest = {motion({0, 0, 0}, {0, 0, 0}), 0.1};
  rest.at_rest = true;
  odometry.add(rest);
  EXPECT_EQ(odometry.step(), step);
  EXPECT_EQ(odometry.camera().twist, Vector6d(Vector6d::Zero()));
  EXPECT_LT(odometry.camera().twist_covariance(0, 0), 1);
}

TEST(MotionIntegrator, TwistIsInTheMovingFrame) {
  MotionIntegrator odometry;
  // A rotation by 90 degrees about y while moving along z: in the final axes the motion was along x.
  odometry.add({motion({0, 0, 2}, {0, M_PI / 2, 0}), 0.5});
  EXPECT_TRUE(odometry.camera().twist.head<3>().isApprox(Eigen::Vector3d(-4, 0, 0), 1e-9))
      << odometry.camera().twist.transpose();
  EXPECT_TRUE(odometry.camera().twist.tail<3>().isApprox(Eigen::Vector3d(0, M_PI, 0), 1e-9));
}

TEST(MotionIntegrator, BaseMovesWithTheCamera) {
  MotionIntegrator odometry;
  odometry.add({motion({0, 0, 1}, {0, 1e-12, 0}), 0.5});
  OdometryEstimate base = odometry.base(kCameraInBase);
  EXPECT_TRUE(base.pose.translation().isApprox(Eigen::Vector3d(1, 0, 0), 1e-9)) << "forward is base x";
  EXPECT_NEAR(base.twist(0), 2, 1e-9);

  // A rotation about the base's origin moves the camera sideways and the base not at all.
  odometry.restart();
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Isometry3d camera = kCameraInBase.inverse() * turn * kCameraInBase;
  RelativePose pose;
  pose.R = camera.linear();
  pose.t = camera.translation();
  odometry.add({pose, 0.1});
  base = odometry.base(kCameraInBase);
  EXPECT_TRUE(base.pose.isApprox(turn, 1e-12));
}

TEST(MotionIntegrator, CovarianceAgreesWithMonteCarlo) {
  Vector6d sigma;
  sigma << 0.02, 0.01, 0.03, 0.004, 0.006, 0.002;
  const int steps = 5, runs = 20000;
  RelativePose exact = kStep;
  // The errors of a pair's translation and rotation are correlated.
  Matrix6d factor = Matrix6d::Identity();
  factor.triangularView<Eigen::StrictlyLower>().setConstant(0.4);
  factor = (sigma.asDiagonal() * factor).eval();
  exact.covariance = factor * factor.transpose();
  MotionIntegrator reference;
  for (int i = 0; i < steps; ++i) reference.add({exact, 0.1});
  const OdometryEstimate camera = reference.camera(), base = reference.base(kCameraInBase);

  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Matrix6d of_camera = Matrix6d::Zero(), of_base = Matrix6d::Zero();
  const auto difference = [](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(a.linear() * b.linear().transpose()));
    Vector6d d;
    d << a.translation() - b.translation(), turn.angle() * turn.axis();
    return d;
  };
  for (int run = 0; run < runs; ++run) {
    MotionIntegrator odometry;
    for (int i = 0; i < steps; ++i) {
      RelativePose noisy = kStep;
      Vector6d e;
      for (int k = 0; k < 6; ++k) e(k) = normal(random);
      e = (factor * e).eval();
      noisy.t += e.head<3>();
      noisy.R = Eigen::AngleAxisd(e.tail<3>().norm(), e.tail<3>().normalized()) * noisy.R;
      odometry.add({noisy, 0.1});
    }
    const Vector6d c = difference(odometry.camera().pose, camera.pose);
    const Vector6d b = difference(odometry.base(kCameraInBase).pose, base.pose);
    of_camera += c * c.transpose() / runs;
    of_base += b * b.transpose() / runs;
  }
  // 20000 runs know a standard deviation to half a percent; linearisation costs as much again.
  EXPECT_LT((of_camera - camera.pose_covariance).norm(), 0.03 * of_camera.norm());
  EXPECT_LT((of_base - base.pose_covariance).norm(), 0.03 * of_base.norm());
}

TEST(MotionIntegrator, WhatWasMissedGoesOneWay) {
  // Two metres a second, lost for a second and a half: the camera is about three metres from where it seems to be.
  MotionIntegrator odometry;
  const RelativePose step = motion({0, 0, 0.2}, {0, 0.02, 0});
  odometry.add({step, 0.1});
  for (int i = 0; i < 15; ++i) odometry.lose(0.1);
  EXPECT_NEAR(std::sqrt(odometry.camera().pose_covariance(2, 2)), 3, 1e-3);
  EXPECT_NEAR(std::sqrt(odometry.camera().pose_covariance(4, 4)), 0.3, 1e-3);
  // A motion missed later is independent: variances add up.
  odometry.add({step, 0.1});
  const Matrix6d before = odometry.camera().pose_covariance;
  odometry.lose(1.5);
  const Matrix6d grown = odometry.camera().pose_covariance - before;
  EXPECT_NEAR(grown(2, 2), 9, 1e-6);
}

TEST(MotionIntegrator, ATranslationThatIsNotKnownIsAsLongAsItsParallaxAllows) {
  MotionIntegrator odometry;
  odometry.add({motion({0, 0, 0.2}, {0, 0.02, 0}), 0.1, true, false, 10});
  const RelativePose turn = motion({0, 0, 0}, {0, 0.02, 0});
  for (int i = 0; i < 4; ++i) odometry.add({turn, 0.1, false, false, 2});
  EXPECT_NEAR(std::sqrt(odometry.camera().pose_covariance(0, 0)), 4 * 0.2 * 2 / 10, 1e-4);
  EXPECT_EQ(odometry.camera().twist_covariance(0, 0), 1e3) << "nothing is said of the velocity";
  EXPECT_LT(odometry.camera().twist_covariance(4, 4), 1) << "but of the rate of turn";
}

TEST(MotionIntegrator, LengthsThatAreGuessedGoOneWay) {
  MotionIntegrator odometry;
  odometry.add({motion({0, 0, 0.2}, {0, 0.02, 0}), 0.1});
  PairMotion guess = {motion({0, 0, 0.2}, {0, 1e-12, 0}), 0.1};
  guess.guessed_length = 0.2;
  for (int i = 0; i < 10; ++i) odometry.add(guess);
  EXPECT_NEAR(std::sqrt(odometry.camera().pose_covariance(0, 0)), 10 * 0.2, 1e-3);
  // A length that is measured ends that.
  odometry.add({motion({0, 0, 0.2}, {0, 1e-12, 0}), 0.1});
  odometry.add(guess);
  EXPECT_NEAR(odometry.camera().pose_covariance(0, 0), 4 + 0.04, 1e-3);
}

TEST(MotionIntegrator, BeforeTheFirstStepNothingIsCertain) {
  const RelativePose turn = motion({0, 0, 0}, {0, 0.02, 0});
  MotionIntegrator standing(0.5), lost(0.5);
  standing.add({turn, 0.1, false, false, 0.2});
  EXPECT_NEAR(std::sqrt(standing.camera().pose_covariance(2, 2)), 0.5, 1e-6);
  lost.lose(0.1);
  EXPECT_NEAR(std::sqrt(lost.camera().pose_covariance(2, 2)), 0.5, 1e-6);
  EXPECT_GT(lost.camera().pose_covariance(4, 4), 0.1);
}

TEST(MotionIntegrator, AfterALossMotionsAreNotUsual) {
  MotionIntegrator odometry;
  odometry.add({kStep, 0.1});
  const MotionIntegrator kept = odometry;
  odometry.add({kStep, 0.1});
  odometry.lose(0.5);
  const RelativePose far = motion({1, 0, 3}, {0.02, 0.4, 0});
  odometry = kept;
  odometry.add({far, 2, true, false, 0, true});
  EXPECT_TRUE(odometry.camera().pose.isApprox(toIsometry(kStep) * toIsometry(far), 1e-12));
  EXPECT_EQ(odometry.camera().twist_covariance(0, 0), 1e3) << "an average over a loss is no velocity";
  EXPECT_EQ(odometry.step(), kStep.t.norm()) << "nor a usual motion";
  EXPECT_NEAR(odometry.stepOf(0.5), 5 * kStep.t.norm(), 1e-12);
}

TEST(MotionIntegrator, APoseThatIsSetIsWhereTheNextMotionBegins) {
  MotionIntegrator odometry;
  const Eigen::Isometry3d there = Eigen::Translation3d(5, 6, 7) * Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX());
  odometry.add({kStep, 0.1});
  odometry.add({kStep, 0.1, true, true});
  odometry.set(there, 4 * Matrix6d::Identity());
  EXPECT_TRUE(odometry.camera().pose.isApprox(there, 1e-12));
  EXPECT_EQ(odometry.camera().pose_covariance, 4 * Matrix6d::Identity());
  // The reference was held: the next pair begins a step before.
  odometry.add({motion({0, 0, 0}, {0, 1e-12, 0}), 0.1});
  EXPECT_TRUE(odometry.camera().pose.isApprox(there * toIsometry(kStep).inverse(), 1e-9));
}

TEST(MotionIntegrator, CovariancesStayFiniteAndBounded) {
  MotionIntegrator odometry;
  RelativePose wild = kStep;
  wild.covariance.setIdentity();
  wild.covariance *= 1e3;
  for (int i = 0; i < 1000; ++i) odometry.add({wild, 1e-3, i % 3 != 0});
  odometry.lose(1e-3);
  for (const Matrix6d& covariance : {odometry.camera().pose_covariance, odometry.camera().twist_covariance}) {
    EXPECT_TRUE(covariance.allFinite());
    EXPECT_LE(covariance.diagonal().maxCoeff(), 1e3 * (1 + 1e-9));
    EXPECT_GE(covariance.diagonal().minCoeff(), 1e-9);
  }
}

}  // namespace
}  // namespace gms_ransac
