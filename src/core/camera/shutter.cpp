#include "gms_ransac/shutter.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

constexpr double kUsualInterval = 1. / 30;  ///< seconds between images without stamps
/// Seconds per focal length of rows that separate the two kinds: global shutters come to 0 to 3 ms, as they are
/// calibrated, those that roll to 9 to 27.
constexpr double kRolls = 0.005;
/// Standard deviations beyond it that are sure. A shutter that is called global by mistake costs wrong answers; one
/// that is called rolling by mistake costs a wrong sentence in the log.
constexpr double kSurelyRolls = 4, kSurelyGlobal = 2;
constexpr int kFewestPairs = 20;

}  // namespace

std::string toString(Shutter::Kind kind) {
  return kind == Shutter::kGlobal ? "global" : kind == Shutter::kRolling ? "rolling" : "unknown";
}

void ShutterEstimate::add(const std::array<double, 3>& rotation, std::optional<double> seconds, const RowRates& rates) {
  latest_ = {seconds.value_or(kUsualInterval) > 0, rotation, rates};
  for (double& velocity : latest_.velocity) velocity /= seconds.value_or(kUsualInterval);
}

void ShutterEstimate::advance() {
  if (before_.known && middle_.known && latest_.known) count(before_, middle_, latest_);
  before_ = middle_;
  middle_ = latest_;
  latest_.known = false;
}

void ShutterEstimate::count(const Pair& before, const Pair& pair, const Pair& after) {
  // The camera rotates at each image as it does in the mean of both intervals.
  std::array<double, 6> velocity;
  for (size_t k = 0; k < 3; ++k) {
    velocity[k] = 0.5 * (before.velocity[k] + pair.velocity[k]);
    velocity[k + 3] = 0.5 * (pair.velocity[k] + after.velocity[k]);
  }
  double sum = 0, weight = 0;
  for (size_t i = 0; i < 6; ++i) {
    sum += velocity[i] * pair.rates.score[i];
    for (size_t j = 0; j < 6; ++j) weight += velocity[i] * pair.rates.information[6 * i + j] * velocity[j];
  }
  if (weight > 0) readout_.add(StreamConstant<1>::Vector(sum), StreamConstant<1>::Matrix(weight));
}

Shutter ShutterEstimate::shutter() const {
  const StreamConstant<1>::Matrix no_prior = StreamConstant<1>::Matrix::Zero();
  const double information = readout_.information(no_prior).value();
  if (!(information > 0)) return {};
  Shutter shutter = {Shutter::kUnknown, readout_.mean(no_prior).value(), 1 / std::sqrt(information)};
  if (pairs() < kFewestPairs) return shutter;
  // The readout begins at the top: one below zero is an error of the rates, and no shutter.
  if (shutter.readout - kRolls > kSurelyRolls * shutter.deviation) shutter.kind = Shutter::kRolling;
  if (kRolls - std::abs(shutter.readout) > kSurelyGlobal * shutter.deviation) shutter.kind = Shutter::kGlobal;
  return shutter;
}

}  // namespace gms_ransac
