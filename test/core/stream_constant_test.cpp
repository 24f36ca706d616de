// StreamConstant: against exact numbers, with evidence whose noise is shared by neighbours.
#include "gms_ransac/stream_constant.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/LU>

namespace gms_ransac {
namespace {

using Rig = StreamConstant<2>;

const Rig::Vector kTruth(0.4, -0.7);
const Rig::Matrix kPrior = Rig::Matrix::Identity();  // a standard deviation of 1

/// Pairs that measure `truth` by two numbers with these standard deviations; half of the noise is that of the pair
/// before.
class Pairs {
 public:
  explicit Pairs(unsigned seed) : random_(seed) {}

  void add(int count, const Rig::Vector& truth, Rig& rig, double claimed = 1) {
    for (int i = 0; i < count; ++i) {
      noise_ = std::sqrt(0.5) * (noise_ + Rig::Vector(normal_(random_), normal_(random_)));
      const Rig::Vector measured = truth + kSigma.cwiseProduct(noise_);
      const Rig::Matrix information = (claimed * kSigma).cwiseAbs2().cwiseInverse().asDiagonal();
      rig.add(information * measured, information);
    }
  }

 private:
  const Rig::Vector kSigma{0.2, 0.5};
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  Rig::Vector noise_ = Rig::Vector::Zero();
};

Rig::Vector deviations(const Rig& rig, const Rig::Vector& truth) {
  const Rig::Matrix covariance = rig.information(kPrior).inverse();
  return (rig.mean(kPrior) - truth).cwiseQuotient(Rig::Vector(covariance.diagonal().cwiseSqrt()));
}

TEST(StreamConstant, BeginsWithItsPrior) {
  const Rig rig(10, 0.98);
  EXPECT_TRUE(rig.mean(kPrior).isZero());
  EXPECT_TRUE(rig.information(kPrior).isApprox(kPrior));
}

TEST(StreamConstant, KnowsHowWellItIsKnown) {
  double squares = 0;
  const int streams = 200;
  for (int stream = 0; stream < streams; ++stream) {
    Rig rig(10, 0.98);
    Pairs(static_cast<unsigned>(stream)).add(400, kTruth, rig, 0.5);  // half of their noise is claimed
    squares += deviations(rig, kTruth).squaredNorm() / 2;
    EXPECT_LT((rig.mean(kPrior) - kTruth).norm(), 0.25);
  }
  EXPECT_GT(squares / streams, 0.4);
  EXPECT_LT(squares / streams, 2);
}

TEST(StreamConstant, PairsThatAreFarOffHardlyMoveIt) {
  Rig rig(1, 1), other(1, 1);
  Pairs(1).add(100, kTruth, rig);
  Pairs(1).add(100, kTruth, other);
  Pairs(2).add(1, {100, -100}, other);
  EXPECT_LT((rig.mean(kPrior) - other.mean(kPrior)).norm(), 0.2);
}

TEST(StreamConstant, BeginsAnewWhereTheStreamTurnsAgainstIt) {
  Rig rig(10, 0.98);
  Pairs pairs(3);
  pairs.add(500, kTruth, rig);
  const Rig::Vector knocked(2.4, 1.3);
  pairs.add(60, knocked, rig);
  EXPECT_LT((rig.mean(kPrior) - knocked).norm(), 0.5);
  pairs.add(500, knocked, rig);
  pairs.add(60, kTruth, rig);
  EXPECT_LT((rig.mean(kPrior) - kTruth).norm(), 0.5) << "and once more";
}

TEST(StreamConstant, WhatIsNotFiniteDoesNotCount) {
  Rig rig;
  rig.add(Rig::Vector::Constant(std::nan("")), kPrior);
  rig.add(kTruth, Rig::Matrix::Constant(INFINITY));
  EXPECT_EQ(rig.groups(), 0);
}

}  // namespace
}  // namespace gms_ransac
