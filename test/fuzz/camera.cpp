// A camera_info becomes a camera, or is refused with a sentence; what the camera undistorts distorts back to the pixel.
// One that cannot be that of the images is doubted or refused, and no other is.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "camera/camera_info.h"
#include "camera/distortion.h"
#include "fuzz_messages.h"
#include "input/camera_model.h"

namespace gms_ransac {
namespace {

// Limit of the round trip, pixels: the accuracy of camera.h, and the rounding of pixels in float.
constexpr double kRoundTrip = 0.01;

void checkPixel(const Camera& camera, const cv::Point2f& pixel) {
  const cv::Point2f ideal = camera.undistort(pixel);
  demand(std::isnan(ideal.x) == std::isnan(ideal.y), "both coordinates or none");
  if (std::isnan(ideal.x)) {
    demand(camera.distorts(), "without distortion every pixel has a ray");
    return;
  }
  // Beyond a million pixels the estimators take no point, and a float's rounding is of their size.
  if (!camera.distorts() || !(std::hypot(ideal.x, ideal.y) < 1e4)) return;
  const CameraIntrinsics& k = camera.pinhole();
  const Distortion distortion(camera.intrinsics());
  const auto astray = [&](double x, double y) {
    const Eigen::Vector2d back = distortion.distort({(x - k.cx) / k.fx, (y - k.cy) / k.fy});
    return std::hypot(k.fx * back.x() + k.cx - pixel.x, k.fy * back.y() + k.cy - pixel.y);
  };
  const double error = astray(ideal.x, ideal.y);
  // With coefficients that describe no lens, the rounding of the answer itself may move the pixel.
  const double rounding = 2.0 * std::numeric_limits<float>::epsilon() * (1 + std::hypot(ideal.x, ideal.y));
  const double rounded = std::max(astray(ideal.x + rounding, ideal.y), astray(ideal.x, ideal.y + rounding));
  if (error < kRoundTrip + std::abs(rounded - error)) return;
  std::ostringstream text;
  text << "the round trip leads " << error << " px astray at " << pixel.x << " " << pixel.y << ", undistorted "
       << ideal.x << " " << ideal.y << ", of " << camera.intrinsics().distortion_model << " fx " << k.fx << " fy "
       << k.fy << " cx " << k.cx << " cy " << k.cy << " D";
  for (const double d : camera.intrinsics().distortion) text << " " << d;
  demandEmpty(text.str());
}

/// A fault of a camera_info.
enum class Fault {
  kNone,
  kHalfSize,    ///< K of images half as large
  kDoubleSize,  ///< or twice as large
  kBinnedTwice,
  kCutTwice,  ///< a region of interest
  kTurned,    ///< by 90 degrees
  kShort,
  kLong,
  kOblong,
  kSideways,   ///< the principal point at an edge
  kNoNumber,   ///< NaN in K
  kOtherSize,  ///< width and height
  kCount
};

/// Full resolution, in the middle of the range of lenses; for `size` images after region and binning.
sensor_msgs::CameraInfo soundInfo(FuzzInput& input, cv::Size size, Fault fault) {
  const bool plain = fault == Fault::kTurned,
             cut = fault == Fault::kCutTwice || (fault == Fault::kNone && input.flag());
  sensor_msgs::CameraInfo info;
  info.binning_x = static_cast<uint32_t>(plain ? 1 : input.between(2, 4));
  info.binning_y = fault == Fault::kNone ? static_cast<uint32_t>(input.between(0, 4)) : info.binning_x;
  info.width = info.binning_x * static_cast<uint32_t>(size.width);
  info.height = std::max(info.binning_y, 1U) * static_cast<uint32_t>(size.height);
  if (cut) {
    info.roi.width = info.width;
    info.roi.height = info.height;
    info.roi.x_offset = fault == Fault::kNone ? static_cast<uint32_t>(input.between(0, 500)) : info.width;
    info.roi.y_offset = static_cast<uint32_t>(input.between(0, 500));
    info.width += info.roi.x_offset;
    info.height += info.roi.y_offset;
  }
  const double longer = std::max(size.width, size.height) * std::max({info.binning_x, info.binning_y, 1U});
  const double f = longer * input.within(0.5, 10);
  info.K = {f, 0, info.width * input.within(0.46, 0.54), 0, f, info.height * input.within(0.46, 0.54), 0, 0, 1};
  return info;
}

void spoil(FuzzInput& input, Fault fault, sensor_msgs::CameraInfo& info) {
  auto& K = info.K;
  static constexpr std::array<size_t, 4> kEntries = {0, 2, 4, 5};
  const auto scale = [&](double by) {
    for (const size_t i : kEntries) K[i] *= by;
  };
  if (fault == Fault::kHalfSize) scale(0.5);
  if (fault == Fault::kDoubleSize) scale(2);
  if (fault == Fault::kBinnedTwice) scale(1.0 / info.binning_x);
  if (fault == Fault::kCutTwice) K[2] -= info.roi.x_offset;
  if (fault == Fault::kTurned) std::swap(K[2], K[5]);
  if (fault == Fault::kShort) K[0] = K[4] *= 0.005;
  if (fault == Fault::kLong) K[0] = K[4] *= 1000;
  if (fault == Fault::kOblong) K[4] *= input.flag() ? 1.25 : 0.8;
  if (fault == Fault::kSideways) K[input.flag() ? 2 : 5] *= input.flag() ? 0.1 : 1.9;
  if (fault == Fault::kNoNumber) K[input.oneOf(kEntries)] = std::numeric_limits<double>::quiet_NaN();
  if (fault == Fault::kOtherSize) (input.flag() ? info.width : info.height) += 4 * (1 + input.byte());
}

void checkFault(FuzzInput& input) {
  const auto fault = static_cast<Fault>(input.between(0, static_cast<int>(Fault::kCount) - 1));
  const cv::Size size(input.between(96, 160), input.between(24, fault == Fault::kTurned ? 48 : 120));
  sensor_msgs::CameraInfo info = soundInfo(input, size, fault);
  spoil(input, fault, info);
  Parameters parameters;
  const bool by_parameters = fault == Fault::kNone && input.flag();
  CameraIntrinsics k = ofK(info);
  applyRegionAndBinning(info, k);
  if (by_parameters) parameters.camera = k;
  const bool other = by_parameters && input.flag();
  if (other) parameters.camera.fx *= 1.3;
  const auto model = CameraModelSource(parameters, "/camera/image_raw", "/camera/camera_info")
                         .get(boost::make_shared<sensor_msgs::CameraInfo>(info), size);
  const std::string said = model->problem + model->doubt, text = std::to_string(static_cast<int>(fault)) + ": " + said;
  demand(said.empty() == (fault == Fault::kNone && !other),
         "what cannot be right is said, and nothing else, fault " + text);
  demand(fault != Fault::kTurned || said.find("turned by 90 degrees") != std::string::npos, "and what it is: " + text);
  if (!said.empty()) return;
  const CameraIntrinsics& found = model->camera.intrinsics();
  demand(found.fx == k.fx && found.fy == k.fy && found.cx == k.cx && found.cy == k.cy,
         "the region is cut, then binned");
}

}  // namespace

void check(FuzzInput input) {
  quietRos();
  if (input.byte() > 192) return checkFault(input);
  Parameters parameters;
  parameters.input_is_rectified = static_cast<Rectified>(input.between(0, 2));
  if (input.byte() > 200) parameters.camera = {300, 310, 160, 120, "plumb_bob", {-0.3, 0.1, 0, 0, 0}};
  CameraModelSource source(parameters, input.flag() ? "/camera/image_rect" : "/camera/image_raw",
                           "/camera/camera_info");
  for (int i = 0; i < 3 && !input.empty(); ++i) {
    const int width = input.between(1, 160), height = input.between(1, 120);
    const sensor_msgs::CameraInfoPtr info = fuzzedCameraInfo(input, width, height);
    const auto model = source.get(input.byte() > 240 ? nullptr : info, {width, height});
    demand(model->problem.empty() == model->camera.calibrated(), "a camera or a sentence");
    demand(model->problem.size() + model->doubt.size() + model->warning.size() < 1000,
           "sentences are short whatever the message says");
    if (!model->camera.calibrated()) continue;
    demand(model->camera.K().allFinite(), "the intrinsics are finite");
    demand(std::isfinite(model->camera.meanFocalLength()), "the mean focal length is finite");
    for (int k = 0; k < 4; ++k) {
      checkPixel(model->camera,
                 {static_cast<float>(input.within(0, width - 1)), static_cast<float>(input.within(0, height - 1))});
    }
    // Outside the image, and no pixel at all: no promise, and no harm.
    model->camera.undistort({input.number32(-1e3f, 1e3f), input.number32(-1e3f, 1e3f)});
  }
}

}  // namespace gms_ransac
