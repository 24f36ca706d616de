// Undistortion against OpenCV's own, and the calibrations that are refused.
#include "gms_ransac/camera.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

namespace gms_ransac {
namespace {

CameraIntrinsics freiburg1() {
  // The strongest plumb_bob distortion of the usual benchmark sets (TUM RGB-D, calibration page).
  return {517.306408, 516.469215,  318.643040,
          255.313989, "plumb_bob", {0.262383, -0.953104, -0.005358, 0.002628, 1.163314}};
}

double worstError(const CameraIntrinsics& intrinsics, cv::Size size) {
  const Camera camera(intrinsics, size);
  std::vector<cv::Point2d> pixels, expected;
  for (double y = 0.25; y <= size.height - 1; y += 7.3) {
    for (double x = 0.75; x <= size.width - 1; x += 7.7) pixels.emplace_back(x, y);
  }
  const cv::Matx33d K(intrinsics.fx, 0, intrinsics.cx, 0, intrinsics.fy, intrinsics.cy, 0, 0, 1);
  if (intrinsics.distortion_model == "equidistant") {
    cv::fisheye::undistortPoints(pixels, expected, K, intrinsics.distortion, cv::noArray(), K);
  } else {
    cv::undistortPoints(pixels, expected, K, intrinsics.distortion, cv::noArray(), K,
                        cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10));
  }
  double worst = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const cv::Point2f got = camera.undistort(pixels[i]);
    worst = std::max(worst, std::hypot(got.x - expected[i].x, got.y - expected[i].y));
  }
  return worst;
}

TEST(Camera, UndistortsLikeOpenCv) {
  EXPECT_LT(worstError(freiburg1(), {640, 480}), 0.005);
  EXPECT_LT(
      worstError({458.654, 457.296, 367.215, 248.375, "plumb_bob", {-0.28340811, 0.07395907, 0.00019359, 1.76e-5}},
                 {752, 480}),
      0.005);
  EXPECT_LT(worstError({600, 600, 320, 240, "rational_polynomial", {0.4, 0.1, 1e-4, -1e-4, 0.01, 0.7, 0.2, 0.03}},
                       {640, 480}),
            0.005);
  EXPECT_LT(worstError({380, 380, 320, 240, "equidistant", {-0.0066, 0.044, -0.042, 0.0077}}, {640, 480}), 0.005);
}

TEST(Camera, LeavesPixelsAloneWithoutDistortion) {
  const Camera camera({718.856, 718.856, 607.2, 185.2, "", {}}, {1241, 376});
  EXPECT_TRUE(camera.calibrated());
  EXPECT_EQ(camera.undistort({17.25f, 300.5f}), cv::Point2f(17.25f, 300.5f));
  EXPECT_FALSE(Camera().calibrated());
  EXPECT_EQ(Camera().undistort({17.25f, 300.5f}), cv::Point2f(17.25f, 300.5f));
}

TEST(Camera, RefusesWhatIsNoCalibrationAndSaysWhy) {
  const auto complaint = [](const CameraIntrinsics& intrinsics) {
    try {
      Camera camera(intrinsics, {640, 480});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(complaint({NAN, 500, 320, 240, "", {}}).find("finite"), std::string::npos);
  EXPECT_NE(complaint({-500, 500, 320, 240, "", {}}).find("negative"), std::string::npos);
  EXPECT_NE(complaint({500, 500, 320, 240, "plumb_bob", {1, 2, 3}}).find("plumb_bob takes 4 or 5"), std::string::npos);
  EXPECT_NE(complaint({500, 500, 320, 240, "thin_prism", {}}).find("'thin_prism'"), std::string::npos);
  EXPECT_EQ(complaint({500, 500, 320, 240, "", {}}), "");
}

}  // namespace
}  // namespace gms_ransac
