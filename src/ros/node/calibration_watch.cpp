#include "node/calibration_watch.h"

#include <algorithm>

namespace gms_ransac {

namespace {

std::string whereToLook(CameraParameter parameter) {
  switch (parameter) {
    case CameraParameter::kFocalLength:
      return "fx and fy of camera_info, or ~camera/fx and fy, may be those of another resolution or zoom";
    case CameraParameter::kPrincipalPoint:
      return "cx and cy of camera_info, or ~camera/cx and cy, may be those of another resolution or crop";
    case CameraParameter::kRadialDistortion:
      return "D of camera_info may be missing or of another lens, or ~input_is_rectified says the wrong thing";
    case CameraParameter::kRollingShutter:
      break;
  }
  return "rows are read one after another while the camera turns; set ~rolling_shutter_readout to the seconds from the "
         "first row to the last, or use a global shutter or slower turns";
}

}  // namespace

void CalibrationWatch::add(const RobustResult& result) {
  const bool contradicts = result.camera_misfit > kMisfit;
  contradicted_.push_back(contradicts ? static_cast<int>(result.misfit_parameter) : kNone);
  if (contradicts) ++contradictions_.at(static_cast<size_t>(result.misfit_parameter));
  if (contradicted_.size() <= kPairs) return;
  if (contradicted_.front() != kNone) --contradictions_[static_cast<size_t>(contradicted_.front())];
  contradicted_.pop_front();
}

void CalibrationWatch::reset() { *this = CalibrationWatch(); }

std::string CalibrationWatch::doubt() const {
  const auto most = std::max_element(contradictions_.begin(), contradictions_.end());
  if (contradicted_.size() < kPairs || *most <= kDoubtAbove) return std::string();
  const auto parameter = static_cast<CameraParameter>(most - contradictions_.begin());
  return "the matches of " + std::to_string(*most) + " of the last " + std::to_string(kPairs) +
         " pairs contradict the camera's " + toString(parameter) + ": " + whereToLook(parameter) +
         "; things that move by themselves in much of the view can look the same";
}

}  // namespace gms_ransac
