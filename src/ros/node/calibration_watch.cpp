#include "node/calibration_watch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace gms_ransac {

namespace {

// Moving objects do not reach this in as many pairs, and a focal length with an error of 3 % nearly always does
// (doc/judgement.md).
constexpr double kLeastSignificance = 8;
constexpr double kLeastAgreeing = 0.9;  // share of the pairs that have the sign of the mean
/// Errors with this share of the largest significance cannot be told from that one.
constexpr double kAsSignificant = 0.6;
/// Smaller errors give no warning.
constexpr std::array<double, CameraErrors::kCount> kSmallest = {0.02, 0.02, 0.02, 0.02, 0.1};
constexpr double kLongestReadout = 1;  // of the time from image to image

constexpr CameraErrors::Parameter kParameters[] = {CameraErrors::kFocalLength, CameraErrors::kPrincipalX,
                                                   CameraErrors::kPrincipalY, CameraErrors::kRadial,
                                                   CameraErrors::kReadoutRotation};

std::string format(const char* text, double value) {
  char buffer[100];
  std::snprintf(buffer, sizeof buffer, text, std::abs(value));
  return buffer;
}

}  // namespace

void CalibrationWatch::add(const RobustResult& result, const std::shared_ptr<const CameraModel>& camera) {
  if (camera != camera_) pairs_.clear();
  camera_ = camera;
  pairs_.push_back({result.camera_misfit > kMisfit, result.camera_errors});
  if (pairs_.size() > kPairs) pairs_.pop_front();
}

std::string CalibrationWatch::doubt() const {
  const auto contradictions =
      std::count_if(pairs_.begin(), pairs_.end(), [](const Pair& pair) { return pair.contradicts; });
  if (pairs_.size() < kPairs || contradictions <= kDoubtAbove) return std::string();
  std::array<Consensus, CameraErrors::kCount> errors;
  double largest = 0;
  for (const auto k : kParameters) {
    errors[k] = consensus(k);
    largest = std::max(largest, errors[k].weight);
  }
  if (!(largest > 0)) return std::string();

  std::string seems, remedies;
  int causes = 0;
  for (const auto k : kParameters) {
    if (errors[k].weight < kAsSignificant * largest) continue;
    const Words said = words(k, errors[k].mean);
    seems += (seems.empty() ? "" : ", or ") + said.error;
    if (remedies.find(said.remedy) != std::string::npos) continue;
    remedies += (remedies.empty() ? "" : ", or ") + said.remedy;
    ++causes;
  }
  return "the matches of " + std::to_string(contradictions) + " of the last " + std::to_string(kPairs) +
         " pairs contradict the camera model in the same way, as if " + seems + ": " + remedies +
         (causes > 1 ? "; these images cannot tell which" : "");
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
  double size = std::abs(consensus.mean);
  if (parameter == CameraErrors::kReadoutRotation) {
    size = -consensus.mean * rows();  // a readout that is too long is refused pair by pair
    if (size > kLongestReadout) return consensus;
  }
  const double significance = std::abs(sum) / std::sqrt(scatter);
  const bool holds = size >= kSmallest[parameter] && significance >= kLeastSignificance &&
                     agreeing >= kLeastAgreeing * static_cast<double>(pairs_.size());
  if (holds) consensus.weight = significance;
  return consensus;
}

CalibrationWatch::Words CalibrationWatch::words(CameraErrors::Parameter parameter, double error) const {
  const CameraIntrinsics& k = camera_->camera.intrinsics();
  const std::string by = error > 0 ? " too large" : " too small", of = " of " + camera_->source + " (another ";
  const std::string centre = "check cx and cy" + of + "resolution or crop?)";
  switch (parameter) {
    case CameraErrors::kFocalLength:
      return {format("fx and fy were %.0f %%", 100 * error) + by, "check fx and fy" + of + "resolution or zoom?)"};
    case CameraErrors::kPrincipalX:
      return {format("cx were %.0f px", error * k.fx) + by, centre};
    case CameraErrors::kPrincipalY:
      return {format("cy were %.0f px", error * k.fy) + by, centre};
    case CameraErrors::kRadial:
      return {format("the first distortion coefficient were %.2f", error) + by,
              camera_->camera.distorts() ? "check the distortion coefficients" + of + "lens?)"
                                         : camera_->source +
                                               " says that the images have no distortion; calibrate the "
                                               "lens, or set ~input_is_rectified"};
    default:
      return {format("~rolling_shutter_readout were %.0f %% of the time from image to image", 100 * error * rows()) +
                  " too short",
              "set ~rolling_shutter_readout to the seconds from the first row of an image to the last, or use a camera "
              "with a global shutter"};
  }
}

}  // namespace gms_ransac
