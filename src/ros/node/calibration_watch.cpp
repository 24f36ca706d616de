#include "node/calibration_watch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace gms_ransac {

namespace {

// What no scene of movers reaches in as many pairs, and a focal length that is 3 % off nearly always does
// (doc/uncertainty.md). Neighbouring pairs see the same things move, so that fewer of them tell than there are.
constexpr double kLeastSignificance = 8;
constexpr double kLeastAgreeing = 0.9;
/// Of the most significant error: where another is as significant, the pairs hardly tell which of them it is.
constexpr double kAsSignificant = 0.6;

/// Smaller ones are not worth a warning.
constexpr std::array<double, CameraErrors::kCount> kSmallest = {0.02, 0.02, 0.02, 0.02, 0.1};
/// Of the time from image to image.
constexpr double kLongestReadout = 1;

constexpr CameraErrors::Parameter kParameters[] = {CameraErrors::kFocalLength, CameraErrors::kPrincipalX,
                                                   CameraErrors::kPrincipalY, CameraErrors::kRadial,
                                                   CameraErrors::kTurnWhileRead};

std::string whereToLook(CameraErrors::Parameter parameter) {
  switch (parameter) {
    case CameraErrors::kFocalLength:
      return "fx and fy of camera_info, or ~camera/fx and fy, may be those of another resolution or zoom";
    case CameraErrors::kPrincipalX:
    case CameraErrors::kPrincipalY:
      return "cx and cy of camera_info, or ~camera/cx and cy, may be those of another resolution or crop";
    case CameraErrors::kRadial:
      return "D of camera_info may be missing or of another lens, or ~input_is_rectified says the wrong thing";
    case CameraErrors::kTurnWhileRead:
      break;
  }
  return "rows are read one after another while the camera turns; set ~rolling_shutter_readout to the seconds from the "
         "first row to the last, or use a global shutter or slower turns";
}

std::string format(const char* text, double value) {
  char buffer[100];
  std::snprintf(buffer, sizeof buffer, text, std::abs(value));
  return buffer;
}

}  // namespace

void CalibrationWatch::add(const RobustResult& result, const Camera& camera) {
  const CameraIntrinsics& intrinsics = camera.intrinsics();
  focal_ = {intrinsics.fx, intrinsics.fy};
  rows_ = camera.imageSize().height / intrinsics.fy;
  pairs_.push_back({result.camera_misfit > kMisfit, result.camera_errors});
  contradictions_ += pairs_.back().contradicts;
  if (pairs_.size() <= kPairs) return;
  contradictions_ -= pairs_.front().contradicts;
  pairs_.pop_front();
}

void CalibrationWatch::reset() { *this = CalibrationWatch(); }

std::string CalibrationWatch::doubt() const {
  if (pairs_.size() < kPairs || contradictions_ <= kDoubtAbove) return std::string();
  std::array<Consensus, CameraErrors::kCount> errors;
  std::array<double, CameraErrors::kCount> weights{};
  for (const auto k : kParameters) weights[k] = weigh(k, errors[k] = consensus(k));
  const auto most =
      static_cast<CameraErrors::Parameter>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  if (!(weights[most] > 0)) return std::string();

  std::string seems = describe(most, errors[most].mean), look = whereToLook(most);
  for (const auto k : kParameters) {
    if (k == most || weights[k] < kAsSignificant * weights[most]) continue;
    seems += ", or " + describe(k, errors[k].mean);
    if (whereToLook(k) != whereToLook(most)) look += "; " + whereToLook(k);
  }
  return "the matches of " + std::to_string(contradictions_) + " of the last " + std::to_string(kPairs) +
         " pairs contradict the camera model, and all ask for the same correction, as if " + seems + ": " + look;
}

CalibrationWatch::Consensus CalibrationWatch::consensus(CameraErrors::Parameter parameter) const {
  double information = 0, sum = 0;
  for (const Pair& pair : pairs_) {
    information += pair.errors.information[parameter];
    sum += pair.errors.information[parameter] * pair.errors.value[parameter];
  }
  Consensus consensus;
  if (!(information > 0)) return consensus;
  consensus.mean = sum / information;
  double scatter = 0;
  int agreeing = 0;
  for (const Pair& pair : pairs_) {
    const double value = pair.errors.value[parameter];
    const double pull = pair.errors.information[parameter] * (value - consensus.mean);
    scatter += pull * pull;
    agreeing += value * consensus.mean > 0;
  }
  consensus.significance = std::abs(sum) / std::sqrt(scatter);
  consensus.agreeing = static_cast<double>(agreeing) / static_cast<double>(pairs_.size());
  return consensus;
}

double CalibrationWatch::weigh(CameraErrors::Parameter parameter, const Consensus& consensus) const {
  double size = std::abs(consensus.mean);
  if (parameter == CameraErrors::kTurnWhileRead) {
    size = -consensus.mean * rows_;  // a readout that is said to be too long is refused pair by pair
    if (size > kLongestReadout) return 0;
  }
  const bool holds = size >= kSmallest[parameter] && consensus.significance >= kLeastSignificance &&
                     consensus.agreeing >= kLeastAgreeing;
  return holds ? consensus.significance : 0;
}

std::string CalibrationWatch::describe(CameraErrors::Parameter parameter, double error) const {
  const std::string by = error > 0 ? " too large" : " too small";
  switch (parameter) {
    case CameraErrors::kFocalLength:
      return format("fx and fy were %.0f %%", 100 * error) + by;
    case CameraErrors::kPrincipalX:
      return format("cx were %.0f px", error * focal_.x()) + by;
    case CameraErrors::kPrincipalY:
      return format("cy were %.0f px", error * focal_.y()) + by;
    case CameraErrors::kRadial:
      return format("the first coefficient of D were %.2f", error) + by;
    case CameraErrors::kTurnWhileRead:
      break;
  }
  return format("~rolling_shutter_readout were %.0f %% of the time from image to image", 100 * error * rows_) +
         " too short";
}

}  // namespace gms_ransac
