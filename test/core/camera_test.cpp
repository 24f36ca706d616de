// The round trip of pixels through OpenCV's model of the lens, and the calibrations that are refused.
#include "gms_ransac/camera.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

namespace gms_ransac {
namespace {

/// The pixel of a ray (x, y, 1) by the papers of the models with one sphere and with two.
cv::Point2d throughSpheres(const CameraIntrinsics& k, const cv::Point3d& ray) {
  const double xi = k.distortion[0], length = cv::norm(ray);
  if (k.distortion_model == "omnidirectional") {
    const cv::Point3d sphere = ray / length;
    const cv::Point3d plane(sphere.x / (sphere.z + xi), sphere.y / (sphere.z + xi), 1);
    std::vector<cv::Point2d> pixel;
    cv::projectPoints(std::vector<cv::Point3d>{plane}, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0),
                      cv::Matx33d(k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1),
                      std::vector<double>(k.distortion.begin() + 1, k.distortion.end()), pixel);
    return pixel[0];
  }
  const double alpha = k.distortion[1], second = std::hypot(ray.x, ray.y, xi * length + ray.z);
  const double below = alpha * second + (1 - alpha) * (xi * length + ray.z);
  return {k.fx * ray.x / below + k.cx, k.fy * ray.y / below + k.cy};
}

/// OpenCV's forward model, which needs no iteration.
std::vector<cv::Point2d> distorted(const CameraIntrinsics& k, const std::vector<cv::Point2d>& ideal) {
  const cv::Matx33d K(k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1);
  const cv::Vec3d none(0, 0, 0);
  std::vector<cv::Point3d> rays;
  for (const cv::Point2d& p : ideal) rays.emplace_back((p.x - k.cx) / k.fx, (p.y - k.cy) / k.fy, 1);
  std::vector<cv::Point2d> pixels;
  if (k.distortion_model == "omnidirectional" || k.distortion_model == "double_sphere") {
    const double magnification = 1 + k.distortion[0];
    for (const cv::Point3d& ray : rays) {
      pixels.push_back(throughSpheres(k, {ray.x * magnification, ray.y * magnification, 1}));
    }
  } else if (k.distortion_model == "equidistant") {
    cv::fisheye::projectPoints(rays, pixels, none, none, K, k.distortion);
  } else {
    cv::projectPoints(rays, none, none, K, k.distortion, pixels);
  }
  return pixels;
}

/// Largest error of the round trip of a pixel, undistorted and distorted again, over the pixels that have a ray.
double worstRoundTrip(const CameraIntrinsics& intrinsics, const Camera& camera) {
  std::vector<cv::Point2d> pixels, ideal;
  for (float y = 0.25f; y <= static_cast<float>(camera.imageSize().height - 1); y += 3.3f) {
    for (float x = 0.75f; x <= static_cast<float>(camera.imageSize().width - 1); x += 3.7f) {
      const cv::Point2f p = camera.undistort({x, y});
      if (std::isnan(p.x) && camera.pixelsWithoutInverse() > 0) continue;
      pixels.emplace_back(x, y);
      ideal.push_back(p);
    }
  }
  if (ideal.empty()) return 0;
  const std::vector<cv::Point2d> back = distorted(intrinsics, ideal);
  double worst = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double error = std::hypot(back[i].x - pixels[i].x, back[i].y - pixels[i].y);
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

TEST(Camera, DistortingAgainGivesEveryPixelBack) {
  // Distortions that grow over the whole image, most of them strong; the first is one on which OpenCV's iteration
  // oscillates.
  const CameraIntrinsics strong[] = {
      {250, 250, 320, 240, "plumb_bob", {-0.4, 0.15, 0, 0, 0}},
      {250, 260, 310, 250, "plumb_bob", {-0.3, 0.1, 2e-3, -1e-3, 0.002}},
      {300, 300, 320, 240, "plumb_bob", {0.6, 0.4, 0, 0, 0.1}},
      {300, 300, 320, 240, "rational_polynomial", {0.4, 0.1, 1e-3, -1e-3, 0.01, 0.7, 0.2, 0.03}},
      {400, 400, 320, 240, "rational_polynomial", {-0.2, 0.1, 0, 0, 0, 0, 0, 0, 0.01, -0.002, 0.02, 0.001}},
      {400, 400, 320, 240, "rational_polynomial", {-0.2, 0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.05, -0.03}},
      {280, 280, 320, 240, "equidistant", {0.01, -0.02, 0.01, -0.002}},
      {380, 380, 320, 240, "equidistant", {-0.0066, 0.044, -0.042, 0.0077}},
      {500, 510, 320, 240, "omnidirectional", {0.9, -0.1, 0.05, 1e-3, -1e-3}},
      {700, 700, 310, 250, "omnidirectional", {1.8, 0.2, 0.1, 0, 0}},
      {300, 300, 320, 240, "double_sphere", {-0.2, 0.6}},
      {400, 390, 330, 230, "double_sphere", {0.3, 0.4}},
      {458.654, 457.296, 367.215, 248.375, "plumb_bob", {-0.28340811, 0.07395907, 0.00019359, 1.76e-5}},  // EuRoC
      // The strongest plumb_bob distortion of the usual benchmark sets (TUM RGB-D, Freiburg 1).
      {517.306408,
       516.469215,
       318.643040,
       255.313989,
       "plumb_bob",
       {0.262383, -0.953104, -0.005358, 0.002628, 1.163314}}};
  for (const CameraIntrinsics& intrinsics : strong) {
    const Camera camera(intrinsics, {640, 480});
    EXPECT_EQ(camera.pixelsWithoutInverse(), 0) << intrinsics.distortion_model << " " << intrinsics.distortion[0];
    EXPECT_LT(worstRoundTrip(intrinsics, camera), 0.0055) << intrinsics.distortion_model << intrinsics.distortion[0];
  }
  EXPECT_NEAR(Camera(strong[0], {640, 480}).undistort({642, 240}).x, 695, 0.5);
}

TEST(Camera, GivesNoPlaceWhereTheModelHasNoInverse) {
  // r - 0.4 r^3 grows up to r = 0.913, which appears at 0.609; atan(r) stays below a right angle; a fisheye lens may
  // fold, too.
  const struct {
    CameraIntrinsics intrinsics;
    double last_radius;  ///< of the received image that has an inverse, pixels
  } cases[] = {{{125, 125, 160, 120, "plumb_bob", {-0.4, 0, 0, 0, 0}}, 125 * 0.6086},
               {{75, 75, 160, 120, "equidistant", {0, 0, 0, 1e-9}}, 75 * std::atan(100)},
               {{125, 125, 160, 120, "equidistant", {-0.3, 0, 0, 0}}, 125 * 0.7027}};
  for (const auto& [intrinsics, last_radius] : cases) {
    const Camera camera(intrinsics, {320, 240});
    int without = 0;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        const double radius = std::hypot(x - 160, y - 120);
        const cv::Point2f ideal = camera.undistort({static_cast<float>(x), static_cast<float>(y)});
        without += std::isnan(ideal.x);
        if (std::abs(radius - last_radius) < 1) continue;
        ASSERT_EQ(std::isnan(ideal.x), radius > last_radius) << x << " " << y;
      }
    }
    EXPECT_EQ(camera.pixelsWithoutInverse(), without) << "of so small an image each is counted";
    EXPECT_TRUE(camera.mayLackInverse());
    EXPECT_NEAR(without, 320 * 240 - CV_PI * last_radius * last_radius, 0.02 * 320 * 240);
    EXPECT_LT(worstRoundTrip(intrinsics, camera), 0.01);
  }
}

TEST(Camera, BeyondARightAngleASphereHasPixelsAndThePinholeHasNone) {
  // A lens of 200 degrees: with xi = 1 a right angle to the axis is 300 pixels from the centre.
  const Camera camera({300, 300, 320, 320, "omnidirectional", {1, 0, 0, 0, 0}}, {640, 640});
  EXPECT_DOUBLE_EQ(camera.pinhole().fx, 150);
  EXPECT_NEAR(camera.undistort({320 + 300 * std::tan(M_PI / 8), 320}).x, 320 + 150, 1e-2) << "45 degrees";
  EXPECT_FALSE(std::isnan(camera.undistort({320 + 295, 320}).x));
  EXPECT_TRUE(std::isnan(camera.undistort({320 + 301, 320}).x));
  EXPECT_NEAR(camera.pixelsWithoutInverse(), 640 * 640 - CV_PI * 300 * 300, 0.03 * 640 * 640);
}

TEST(Camera, IntrinsicsAreThoseGiven) {
  const CameraIntrinsics given = {300, 310, 320, 240, "omnidirectional", {1, 0.1, 0, 0, 0}};
  const Camera camera(given, {640, 480}), again(camera.intrinsics(), {640, 480});
  EXPECT_EQ(camera.intrinsics().fx, given.fx);
  EXPECT_EQ(camera.intrinsics().distortion, given.distortion);
  EXPECT_EQ(again, camera);
  EXPECT_EQ(again.undistort({500, 100}), camera.undistort({500, 100}));
}

TEST(Camera, TakesZerosBehindTheCoefficientsOfItsModel) {
  const struct {
    const char* model;
    std::vector<double> coefficients;
    size_t zeros;
  } cases[] = {{"plumb_bob", {-0.3, 0.1, 1e-3, -1e-3, 0.01}, 3},
               {"equidistant", {-0.02, 0.01, -0.003, 0.001}, 1},
               {"equidistant", {0, 0, 0, 0}, 1},
               {"omnidirectional", {0.5, -0.1, 0, 0, 0}, 3},
               {"double_sphere", {-0.2, 0.6}, 3}};
  for (const auto& [model, coefficients, zeros] : cases) {
    std::vector<double> filled = coefficients;
    filled.resize(filled.size() + zeros);
    const Camera plain({250, 250, 320, 240, model, coefficients}, {640, 480});
    const Camera longer({250, 250, 320, 240, model, filled}, {640, 480});
    for (const cv::Point2f pixel : {cv::Point2f(400, 300), cv::Point2f(10, 20)}) {
      const cv::Point2f a = plain.undistort(pixel), b = longer.undistort(pixel);
      EXPECT_TRUE(a == b || (std::isnan(a.x) && std::isnan(b.x))) << model;
    }
    filled.back() = 1e-3;
    EXPECT_THROW(Camera({250, 250, 320, 240, model, filled}, {640, 480}), std::invalid_argument) << model;
  }
}

TEST(Camera, SpheresHaveBounds) {
  const auto complaint = [](const std::string& model, const std::vector<double>& values) -> std::string {
    try {
      CameraIntrinsics{300, 300, 320, 240, model, values}.validate();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint("omnidirectional", {-1, 0, 0, 0, 0}), "intrinsics: xi must be above -1");
  EXPECT_EQ(complaint("double_sphere", {0.5, 1.1}), "intrinsics: alpha must be between 0 and 1");
  EXPECT_EQ(complaint("double_sphere", {0.5}),
            "intrinsics: double_sphere takes 2 (xi, alpha) distortion coefficients, not 1");
  EXPECT_EQ(complaint("double_sphere", {-0.2, 0.6}), "");
}

TEST(Camera, EstimatesOfALargeImageHowManyPixelsHaveNoInverse) {
  // The same lens before a sensor of nine times the pixels, of which a ninth as many are checked.
  const Camera small({250, 250, 320, 240, "plumb_bob", {-0.4, 0, 0, 0, 0}}, {640, 480});
  const Camera large({750, 750, 960, 720, "plumb_bob", {-0.4, 0, 0, 0, 0}}, {1920, 1440});
  EXPECT_NEAR(large.pixelsWithoutInverse() / 9.0, small.pixelsWithoutInverse(), 1000);
}

TEST(Camera, TakesAnyPixelAndAnyCalibration) {
  // For any coefficients the answer is a right place, or none.
  const std::vector<double> values = {-1e6, -3, -0.5, 0, 0.3, 2, 1e6};
  for (double k1 : values) {
    for (double k2 : values) {
      for (const CameraIntrinsics& intrinsics :
           {CameraIntrinsics{300, 300, 40, 30, "plumb_bob", {k1, k2, 0.01, -0.01, 0}},
            CameraIntrinsics{300, 300, 40, 30, "rational_polynomial", {k1, 0, 0, 0, 0, k2, 0, 0}},
            CameraIntrinsics{300, 300, 40, 30, "equidistant", {k1, k2, 0, 0}}}) {
        const Camera camera(intrinsics, {80, 60});
        EXPECT_LT(worstRoundTrip(intrinsics, camera), 0.01) << intrinsics.distortion_model << k1 << " " << k2;
        EXPECT_EQ(camera.distorts(), intrinsics.distortion_model != "rational_polynomial" || k1 != 0 || k2 != 0);
        if (!camera.distorts()) continue;
        for (const float far : {-1e30f, -1e4f, 1e4f, 1e30f, NAN, INFINITY}) {
          const cv::Point2f ideal = camera.undistort({far, 10});
          EXPECT_EQ(std::isnan(ideal.x), std::isnan(ideal.y));
        }
      }
    }
  }
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
  // In single precision the squared coordinates of a pixel's ray would be infinite.
  EXPECT_NE(complaint({1e-110, 500, 320, 240, "", {}}).find("between 0.001 and 1e6"), std::string::npos);
  EXPECT_NE(complaint({500, 1e300, 320, 240, "", {}}).find("between 0.001 and 1e6"), std::string::npos);
  EXPECT_NE(complaint({500, 500, -1e9, 240, "", {}}).find("within 1e6"), std::string::npos);
  EXPECT_NE(complaint({500, 500, 320, 240, "plumb_bob", {1, 2, 3}}).find("plumb_bob takes 4 or 5"), std::string::npos);
  EXPECT_NE(complaint({500, 500, 320, 240, "thin_prism", {}}).find("'thin_prism'"), std::string::npos);
  EXPECT_EQ(complaint({500, 500, 320, 240, "", {}}), "");
}

}  // namespace
}  // namespace gms_ransac
