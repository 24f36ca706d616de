// A camera_info becomes a camera, or is refused with a sentence; what the camera undistorts distorts back to the pixel.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

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

}  // namespace

void check(FuzzInput input) {
  quietRos();
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
    demand(model->problem.size() < 1000, "a refusal is short whatever the message says");
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
