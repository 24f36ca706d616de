// A calibration is doubted while most pairs contradict the same parameter of it, and only then.
#include "node/calibration_watch.h"

#include <gtest/gtest.h>

#include "drive_scene.h"

namespace gms_ransac {
namespace {

RobustResult pair(double misfit, CameraParameter parameter) {
  RobustResult result;
  result.camera_misfit = misfit;
  result.misfit_parameter = parameter;
  return result;
}

void add(int pairs, double misfit, CameraParameter parameter, CalibrationWatch& watch) {
  for (int i = 0; i < pairs; ++i) watch.add(pair(misfit, parameter));
}

TEST(CalibrationWatch, NamesTheParameterOfMostPairs) {
  for (const auto& [parameter, words] : {std::make_pair(CameraParameter::kFocalLength, "fx and fy of camera_info"),
                                         std::make_pair(CameraParameter::kPrincipalPoint, "cx and cy of camera_info"),
                                         std::make_pair(CameraParameter::kRadialDistortion, "~input_is_rectified"),
                                         std::make_pair(CameraParameter::kRollingShutter, "rows are read")}) {
    CalibrationWatch watch;
    add(14, 0.5, parameter, watch);
    add(15, 3, parameter, watch);
    EXPECT_EQ(watch.doubt(), "") << "29 pairs are too few";
    add(1, 3, parameter, watch);
    EXPECT_NE(watch.doubt().find("16 of the last 30 pairs contradict the camera's " + toString(parameter)),
              std::string::npos)
        << watch.doubt();
    EXPECT_NE(watch.doubt().find(words), std::string::npos) << watch.doubt();
  }
}

TEST(CalibrationWatch, HalfThePairsAreNotEnough) {
  CalibrationWatch watch;
  add(15, 0.5, CameraParameter::kFocalLength, watch);
  add(15, 3, CameraParameter::kFocalLength, watch);
  EXPECT_EQ(watch.doubt(), "");
}

TEST(CalibrationWatch, DifferentParametersAreNoCalibration) {
  CalibrationWatch watch;
  add(15, 3, CameraParameter::kFocalLength, watch);
  add(15, 3, CameraParameter::kRollingShutter, watch);
  EXPECT_EQ(watch.doubt(), "");
}

TEST(CalibrationWatch, GoesAwayWhenItStops) {
  CalibrationWatch watch;
  add(100, 3, CameraParameter::kFocalLength, watch);
  EXPECT_NE(watch.doubt(), "");
  add(14, 0.5, CameraParameter::kFocalLength, watch);
  EXPECT_NE(watch.doubt().find("16 of the last 30"), std::string::npos) << watch.doubt();
  add(1, 0.5, CameraParameter::kFocalLength, watch);
  EXPECT_EQ(watch.doubt(), "");
}

TEST(CalibrationWatch, AnotherCameraStartsAnew) {
  CalibrationWatch watch;
  add(100, 3, CameraParameter::kFocalLength, watch);
  watch.reset();
  add(10, 3, CameraParameter::kFocalLength, watch);
  EXPECT_EQ(watch.doubt(), "");
}

/// The doubt after 40 pairs of a camera that moves sideways and nods by four degrees, if its focal length (500 px) is
/// said to be this.
std::string doubtAfterADrive(double focal_length) {
  CameraIntrinsics intrinsics = sceneCamera().intrinsics();
  intrinsics.fx = intrinsics.fy = focal_length;
  const Camera camera(intrinsics, sceneCamera().imageSize());
  Drive drive(1, makeStep({0.4, 0, 0}, {4 * M_PI / 180, 0, 0}), true);
  const auto estimator = makeEstimator("lo_prosac", RobustOptions());
  CalibrationWatch watch;
  RobustResult result;
  for (int i = 0; i < 40; ++i) {
    estimator->estimate(drive.advance(), camera, result);
    watch.add(result);
  }
  return watch.doubt();
}

TEST(CalibrationWatch, FindsAFocalLengthThatIsFivePercentOff) {
  EXPECT_EQ(doubtAfterADrive(500), "");
  EXPECT_NE(doubtAfterADrive(525).find("focal length"), std::string::npos);
  EXPECT_NE(doubtAfterADrive(475).find("focal length"), std::string::npos);
}

}  // namespace
}  // namespace gms_ransac
