// Learns from the pairs of a stream whether the camera's shutter rolls.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "gms_ransac/stream_constant.h"

namespace gms_ransac {

/// The camera's shutter, learnt from the stream.
struct Shutter {
  enum Kind : uint8_t { kUnknown, kGlobal, kRolling };
  Kind kind = kUnknown;
  double readout = 0;    ///< seconds for as many rows as the focal length has pixels
  double deviation = 0;  ///< its standard deviation; 0: nothing is known
};
std::string toString(Shutter::Kind kind);  ///< "unknown", "global", "rolling"

/// Angular velocity of a camera between two images, in its axes, rad/s.
struct AngularVelocity {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  double variance = 0;  ///< of the three together
};

/// Evidence of a pair for the rates of rotation by row, radians per focal length: three of the reference, three of the
/// current image. Combines their score s, its information I and its scatter S; matrices by rows.
struct RowRates {
  std::array<double, 6> score{};         ///< I S^-1 s
  std::array<double, 36> information{};  ///< I S^-1 I
};

/// Sums up the pairs of a stream. A shutter needs tau seconds for a focal length of rows. Its rates are then tau times
/// the angular velocity w of the camera at either image, which the neighbouring pairs measure: s = tau I w + noise of
/// S. So each pair counts when the next one is known. Where points have an error of many pixels the scores tell too
/// little of it; they are exact once the points are corrected by nearly tau, and show the rest.
class ShutterEstimate {
 public:
  /// A pair of the stream. `corrected`: the tau that its points were corrected by.
  void add(const AngularVelocity& velocity, const RowRates& rates, double corrected = 0);
  /// The current image of the pair added last becomes the reference of the next one; without a pair the chain breaks.
  void advance();

  /// Returns unknown until tau is above 5 ms by four standard deviations, or below by two.
  Shutter shutter() const;
  /// Velocity over the pair whose current image is the reference of the next one.
  std::optional<AngularVelocity> velocityBefore() const;
  int pairs() const { return kPairsOfGroup * readout_.groups(); }

 private:
  static constexpr int kPairsOfGroup = 5;
  static constexpr double kKept = 0.9;  ///< so that the first pairs, whose points were not corrected, are forgotten

  struct Pair {
    bool known = false;
    AngularVelocity velocity;
    RowRates rates;
    double corrected = 0;
  };
  void count(const Pair& before, const Pair& pair, const Pair& after);

  Pair before_, middle_, latest_;
  StreamConstant<1> readout_{kPairsOfGroup, kKept};
};

}  // namespace gms_ransac
