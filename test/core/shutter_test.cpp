// The shutter learnt from a stream: rates by row that are, or are not, those of a camera that rotates.
#include "gms_ransac/shutter.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

/// A stream of a camera that is swung about two axes, whose shutter needs `readout` seconds for a focal length of rows.
/// Rates are measured with `noise` radians. `seen`: share of the rest of the readout that the scores show. `correct`:
/// the points of a pair are corrected by what is known.
ShutterEstimate swing(double readout, int pairs, double noise = 0.01, double seen = 1, bool correct = false) {
  ShutterEstimate estimate;
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, noise);
  const auto velocity = [](double image, int axis) { return axis < 2 ? std::sin(0.2 * image + axis) : 0; };
  for (int i = 0; i < pairs; ++i) {
    const double corrected = correct ? estimate.shutter().readout : 0;
    AngularVelocity rotation;
    RowRates rates;
    for (int k = 0; k < 3; ++k) {
      rotation.value[k] = velocity(i + 0.5, k);
      for (int image = 0; image < 2; ++image) {
        const auto row = static_cast<size_t>(3 * image + k);
        rates.information[7 * row] = 1 / (noise * noise);
        rates.score[row] =
            rates.information[7 * row] * (normal(random) - seen * (readout - corrected) * velocity(i + image, k));
      }
    }
    estimate.add(rotation, rates, corrected);
    estimate.advance();
  }
  return estimate;
}

TEST(ShutterEstimate, TellsOneThatRollsFromOneThatDoesNot) {
  const ShutterEstimate rolling = swing(0.014, 200), global = swing(0, 200);
  EXPECT_EQ(rolling.shutter().kind, Shutter::kRolling);
  EXPECT_NEAR(rolling.shutter().readout, 0.014, 3 * rolling.shutter().deviation);
  EXPECT_LT(rolling.shutter().deviation, 0.0012);
  EXPECT_EQ(global.shutter().kind, Shutter::kGlobal);
  EXPECT_NEAR(global.shutter().readout, 0, 3 * global.shutter().deviation);
}

TEST(ShutterEstimate, IsUnknownWithFewPairsOrLittleRotation) {
  EXPECT_EQ(ShutterEstimate().shutter().kind, Shutter::kUnknown);
  EXPECT_EQ(swing(0.014, 15).shutter().kind, Shutter::kUnknown);
  EXPECT_EQ(swing(0.014, 200, 1).shutter().kind, Shutter::kUnknown);
  EXPECT_EQ(swing(0, 200, 1).shutter().kind, Shutter::kUnknown);
}

TEST(ShutterEstimate, ReadsNoImageFromTheBottomUp) { EXPECT_EQ(swing(-0.014, 200).shutter().kind, Shutter::kUnknown); }

TEST(ShutterEstimate, ScoresThatTellAQuarterShowTheWholeOnceThePointsAreCorrected) {
  const Shutter once = swing(0.03, 600, 0.01, 0.25).shutter(), corrected = swing(0.03, 600, 0.01, 0.25, true).shutter();
  EXPECT_NEAR(once.readout, 0.0075, 3 * once.deviation);
  EXPECT_NEAR(corrected.readout, 0.03, 0.0015);
  EXPECT_EQ(corrected.kind, Shutter::kRolling);
}

TEST(ShutterEstimate, ABrokenChainCountsNothing) {
  ShutterEstimate estimate = swing(0.014, 200);
  const int before = estimate.pairs();
  estimate.advance();  // a pair without a pose
  estimate.add({{3, 0, 0}, 0}, {});
  estimate.advance();
  estimate.add({{3, 0, 0}, 0}, {});
  estimate.advance();
  EXPECT_EQ(estimate.pairs(), before);
}

TEST(ShutterEstimate, AFewWrongPairsDoNotDecide) {
  ShutterEstimate estimate = swing(0, 200);
  RowRates wild;
  wild.information.fill(0);
  // As certain as the others, and of another camera.
  for (size_t k = 0; k < 6; ++k) wild.information[7 * k] = 1e4, wild.score[k] = -1e4;
  for (int i = 0; i < 3; ++i) {
    estimate.add({{1, 1, 0}, 0}, wild);
    estimate.advance();
  }
  EXPECT_EQ(estimate.shutter().kind, Shutter::kGlobal);
  RowRates broken;
  broken.score.fill(std::numeric_limits<double>::quiet_NaN());
  estimate.add({{1, 1, 0}, 0}, broken);
  estimate.advance();
  estimate.advance();
  EXPECT_TRUE(std::isfinite(estimate.shutter().readout));
}

}  // namespace
}  // namespace gms_ransac
