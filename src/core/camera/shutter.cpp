#include "gms_ransac/shutter.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

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

void ShutterEstimate::add(const AngularVelocity& velocity, const RowRates& rates, double corrected) {
  latest_ = {true, velocity, rates, corrected};
}

void ShutterEstimate::advance() {
  if (before_.known && middle_.known && latest_.known) count(before_, middle_, latest_);
  before_ = middle_;
  middle_ = latest_;
  latest_.known = false;
}

std::optional<AngularVelocity> ShutterEstimate::velocityBefore() const {
  if (!middle_.known) return std::nullopt;
  return middle_.velocity;
}

void ShutterEstimate::count(const Pair& before, const Pair& pair, const Pair& after) {
  using Vector = Eigen::Matrix<double, 6, 1>;
  // The camera rotates at each image as it does in the mean of both intervals; points move against it.
  Vector velocity;
  velocity << before.velocity.value + pair.velocity.value, pair.velocity.value + after.velocity.value;
  velocity *= -0.5;
  const double score = velocity.dot(Eigen::Map<const Vector>(pair.rates.score.data()));
  const Eigen::Map<const Eigen::Matrix<double, 6, 6>> rates(pair.rates.information.data());
  const double information = velocity.dot(rates * velocity);
  if (!(information > 0)) return;
  readout_.add(StreamConstant<1>::Vector(score + pair.corrected * information), StreamConstant<1>::Matrix(information));
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
