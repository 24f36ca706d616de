// The camera of an image by its camera_info, the same for the node and for the programs that read bags. `Info` is
// sensor_msgs/CameraInfo, a template parameter because the core includes no ROS.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>

#include "camera/distortion.h"
#include "gms_ransac/camera.h"

namespace gms_ransac {

/// ~input_is_rectified: true: the images have no distortion and P describes them; false: K and D do.
enum class Rectified { kAuto, kTrue, kFalse };

/// No model has as many coefficients; a message may claim any number.
constexpr std::ptrdiff_t kMostCoefficients = 100;

template <typename Info>
CameraIntrinsics ofK(const Info& info) {
  return {info.K[0], info.K[4], info.K[2], info.K[5], "", {}};
}

template <typename Info>
CameraIntrinsics ofP(const Info& info) {
  return {info.P[0], info.P[5], info.P[2], info.P[6], "", {}};
}

/// K and P are those of the full-resolution image: shifts to the region of interest, then bins.
template <typename Info>
void applyRegionAndBinning(const Info& info, CameraIntrinsics& intrinsics) {
  const double bx = std::max(info.binning_x, 1u), by = std::max(info.binning_y, 1u);
  intrinsics.cx = (intrinsics.cx - info.roi.x_offset) / bx;
  intrinsics.cy = (intrinsics.cy - info.roi.y_offset) / by;
  intrinsics.fx /= bx;
  intrinsics.fy /= by;
}

/// Returns true if P describes the image, by the topic's name and the distortion when that is not given.
template <typename Info>
bool isRectified(const Info& info, const std::string& image_topic, Rectified given) {
  if (info.K[0] == 0) return true;  // kitti2bag's odometry bags fill P alone
  if (given != Rectified::kAuto) return given == Rectified::kTrue;
  // "image_rect", "/rect/image"; but not "/direct/image". kitti2bag calls the rectified images of raw drives image_raw,
  // next to the K and D of the camera before.
  for (const char* word : {"_rect", "/rect", "/kitti/camera_"}) {
    if (image_topic.find(word) != std::string::npos) return true;
  }
  if (commonModelName(info.distortion_model) == "equidistant" && !info.D.empty()) return false;  // zeros: r = f angle
  return std::all_of(info.D.begin(), info.D.end(), [](double d) { return d == 0; });
}

/// Throws unless both are positive or, where the matrix is not given, 0.
inline void requireFocalLengths(const char* matrix, const CameraIntrinsics& k, const std::string& or_set) {
  if ((k.fx == 0 && k.fy == 0) || (k.calibrated() && std::isfinite(k.fx) && std::isfinite(k.fy))) return;
  std::ostringstream text;
  text << "fx is " << k.fx << " and fy is " << k.fy << " in " << matrix
       << ", both must be above 0; calibrate the camera" << or_set;
  throw std::invalid_argument(text.str());
}

/// Intrinsics of the received image; not calibrated if K and P are 0. Throws std::invalid_argument with the end of a
/// sentence, which `or_set` completes.
template <typename Info>
CameraIntrinsics intrinsicsOf(const Info& info, const std::string& image_topic, Rectified given,
                              const std::string& or_set) {
  const CameraIntrinsics k = ofK(info), p = ofP(info);
  requireFocalLengths("K", k, or_set);
  const bool rectified = isRectified(info, image_topic, given), from_p = rectified && p.fx != 0;
  if (rectified) requireFocalLengths("P", p, or_set);
  CameraIntrinsics intrinsics = from_p ? p : k;
  if (intrinsics.fx == 0) return {};
  // A principal point in the corner is one that was not filled in, and poses from it are wrong.
  if (intrinsics.cx == 0 && intrinsics.cy == 0) {
    throw std::invalid_argument(std::string("cx and cy are 0 in ") + (from_p ? "P" : "K") + "; calibrate the camera" +
                                or_set);
  }
  applyRegionAndBinning(info, intrinsics);
  // So small a number that binning makes 0 of it, which would pass for a camera that is not calibrated.
  if (!intrinsics.calibrated()) throw std::invalid_argument("fx and fy are 0 after binning");
  if (!rectified) {
    intrinsics.distortion_model = commonModelName(info.distortion_model);
    intrinsics.distortion.assign(
        info.D.begin(), info.D.begin() + std::min(std::distance(info.D.begin(), info.D.end()), kMostCoefficients));
  }
  return intrinsics;
}

}  // namespace gms_ransac
