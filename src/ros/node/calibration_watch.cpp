#include "node/calibration_watch.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core/utility.hpp>

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
  std::array<double, CameraErrors::kCount> error{}, weight{};
  for (size_t k = 0; k < error.size(); ++k) weight[k] = significance(k, error[k]);
  const double largest = *std::max_element(weight.begin(), weight.end());
  if (!(largest > 0)) return std::string();

  std::string seems, remedies;
  int causes = 0;
  for (size_t k = 0; k < error.size(); ++k) {
    if (weight[k] < kAsSignificant * largest) continue;
    const auto [what, remedy] = words(k, error[k]);
    seems += (seems.empty() ? "" : ", or ") + what;
    if (remedies.find(remedy) != std::string::npos) continue;
    remedies += (remedies.empty() ? "" : ", or ") + remedy;
    ++causes;
  }
  return "the matches of " + std::to_string(contradictions) + " of the last " + std::to_string(kPairs) +
         " pairs contradict the camera model in the same way, as if " + seems + ": " + remedies +
         (causes > 1 ? "; these images cannot tell which" : "");
}

double CalibrationWatch::significance(size_t parameter, double& mean) const {
  double information = 0, sum = 0;
  for (const Pair& pair : pairs_) {
    information += pair.errors.information[parameter];
    sum += pair.errors.information[parameter] * pair.errors.value[parameter];
  }
  if (!(information > 0)) return 0;
  mean = sum / information;
  double scatter = 0;
  int agreeing = 0;
  for (const Pair& pair : pairs_) {
    const double value = pair.errors.value[parameter];
    const double pull = pair.errors.information[parameter] * (value - mean);
    scatter += pull * pull;
    agreeing += value * mean > 0;
  }
  double size = std::abs(mean);
  if (parameter == CameraErrors::kReadoutRotation) {
    size = -mean * rows();  // a readout that is too long is refused pair by pair
    if (size > kLongestReadout) return 0;
  }
  const double significance = std::abs(sum) / std::sqrt(scatter);
  const bool holds = size >= kSmallest[parameter] && significance >= kLeastSignificance &&
                     agreeing >= kLeastAgreeing * static_cast<double>(pairs_.size());
  return holds ? significance : 0;
}

std::pair<std::string, std::string> CalibrationWatch::words(size_t parameter, double error) const {
  const CameraIntrinsics& k = camera_->camera.intrinsics();
  const double size = std::abs(error);
  const std::string by = error > 0 ? " too large" : " too small", of = " of " + camera_->source + " (another ";
  const std::string centre = "check cx and cy" + of + "resolution or crop?)";
  switch (parameter) {
    case CameraErrors::kFocalLength:
      return {cv::format("fx and fy were %.0f %%", 100 * size) + by, "check fx and fy" + of + "resolution or zoom?)"};
    case CameraErrors::kPrincipalX:
      return {cv::format("cx were %.0f px", size * k.fx) + by, centre};
    case CameraErrors::kPrincipalY:
      return {cv::format("cy were %.0f px", size * k.fy) + by, centre};
    case CameraErrors::kRadial:
      return {cv::format("the first distortion coefficient were %.2f", size) + by,
              camera_->camera.distorts() ? "check the distortion coefficients" + of + "lens?)"
                                         : camera_->source +
                                               " says that the images have no distortion; calibrate the "
                                               "lens, or set ~input_is_rectified"};
    default:
      return {cv::format("~rolling_shutter_readout were %.0f %% of the time from image to image", 100 * size * rows()) +
                  " too short",
              "set ~rolling_shutter_readout to the seconds from the first row of an image to the last, or use a camera "
              "with a global shutter"};
  }
}

}  // namespace gms_ransac
