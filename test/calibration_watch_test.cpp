// A calibration is doubted while most pairs contradict the camera model and ask for the same correction, and only then.
#include "node/calibration_watch.h"

#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "drive_scene.h"
#include "scenes/drawn_scenes.h"

namespace gms_ransac {
namespace {

constexpr int kWindow = static_cast<int>(CalibrationWatch::kPairs);

/// A pair that contradicts or not, and knows one error to a tenth.
RobustResult pair(double misfit, CameraErrors::Parameter parameter, double error) {
  RobustResult result;
  result.camera_misfit = misfit;
  result.camera_errors.value[parameter] = error;
  result.camera_errors.information[parameter] = 100 / (error * error);
  return result;
}

/// Pairs whose errors are these, half a tenth more and half a tenth less in turn.
void add(int pairs, double misfit, CameraErrors::Parameter parameter, double error, CalibrationWatch& watch) {
  for (int i = 0; i < pairs; ++i) {
    watch.add(pair(misfit, parameter, error * (i % 2 ? 1.05 : 0.95)), sceneCamera());
  }
}

bool contains(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

TEST(CalibrationWatch, NamesWhatTheCorrectionIs) {
  struct Case {
    CameraErrors::Parameter parameter;
    double error;
    const char* seems;
    const char* look;
  };
  for (const Case& c :
       {Case{CameraErrors::kFocalLength, 0.05, "fx and fy were 5 % too large", "fx and fy of camera_info"},
        Case{CameraErrors::kFocalLength, -0.03, "fx and fy were 3 % too small", "fx and fy of camera_info"},
        Case{CameraErrors::kPrincipalX, 0.04, "cx were 20 px too large", "cx and cy of camera_info"},
        Case{CameraErrors::kPrincipalY, -0.04, "cy were 20 px too small", "cx and cy of camera_info"},
        Case{CameraErrors::kRadial, 0.05, "the first coefficient of D were 0.05 too large", "~input_is_rectified"},
        Case{CameraErrors::kTurnWhileRead, -0.5,
             "~rolling_shutter_readout were 48 % of the time from image to image too short", "rows are read"}}) {
    CalibrationWatch watch;
    add(kWindow - 31, 0.5, c.parameter, c.error, watch);
    add(30, 3, c.parameter, c.error, watch);
    EXPECT_EQ(watch.doubt(), "") << "59 pairs are too few";
    add(1, 3, c.parameter, c.error, watch);
    EXPECT_TRUE(contains(watch.doubt(), "31 of the last 60 pairs contradict the camera model")) << watch.doubt();
    EXPECT_TRUE(contains(watch.doubt(), c.seems)) << watch.doubt();
    EXPECT_TRUE(contains(watch.doubt(), c.look)) << watch.doubt();
  }
}

TEST(CalibrationWatch, HalfThePairsAreNotEnough) {
  CalibrationWatch watch;
  add(30, 0.5, CameraErrors::kFocalLength, 0.05, watch);
  add(30, 3, CameraErrors::kFocalLength, 0.05, watch);
  EXPECT_EQ(watch.doubt(), "");
}

TEST(CalibrationWatch, SignsThatChangeAreNoCalibration) {
  CalibrationWatch watch;
  for (int i = 0; i < 6; ++i) add(10, 30, CameraErrors::kFocalLength, i == 2 ? -0.05 : 0.05, watch);
  EXPECT_EQ(watch.doubt(), "");
}

TEST(CalibrationWatch, SmallErrorsAreNotWorthAWarning) {
  CalibrationWatch watch;
  add(kWindow, 30, CameraErrors::kFocalLength, 0.01, watch);
  EXPECT_EQ(watch.doubt(), "");
}

TEST(CalibrationWatch, NoCameraReadsItsRowsForLongerThanFromImageToImageOrBackwards) {
  for (const double error : {-2., 0.5}) {
    CalibrationWatch watch;
    add(kWindow, 30, CameraErrors::kTurnWhileRead, error, watch);
    EXPECT_EQ(watch.doubt(), "");
  }
}

TEST(CalibrationWatch, NamesBothOfTwoThatCannotBeTold) {
  CalibrationWatch watch;
  for (int i = 0; i < kWindow; ++i) {
    const double change = i % 2 ? 1.05 : 0.95;
    RobustResult result = pair(3, CameraErrors::kFocalLength, 0.05 * change);
    result.camera_errors.value[CameraErrors::kRadial] = -0.03 * change;
    result.camera_errors.information[CameraErrors::kRadial] = 1e5;
    watch.add(result, sceneCamera());
  }
  EXPECT_TRUE(contains(watch.doubt(), "fx and fy were 5 % too large")) << watch.doubt();
  EXPECT_TRUE(contains(watch.doubt(), "the first coefficient of D were 0.03 too small")) << watch.doubt();
}

TEST(CalibrationWatch, GoesAwayWhenItStops) {
  CalibrationWatch watch;
  add(100, 3, CameraErrors::kFocalLength, 0.05, watch);
  EXPECT_NE(watch.doubt(), "");
  add(29, 0.5, CameraErrors::kFocalLength, 0.05, watch);
  EXPECT_TRUE(contains(watch.doubt(), "31 of the last 60")) << watch.doubt();
  add(1, 0.5, CameraErrors::kFocalLength, 0.05, watch);
  EXPECT_EQ(watch.doubt(), "");
}

TEST(CalibrationWatch, AnotherCameraStartsAnew) {
  CalibrationWatch watch;
  add(100, 3, CameraErrors::kFocalLength, 0.05, watch);
  watch.reset();
  add(10, 3, CameraErrors::kFocalLength, 0.05, watch);
  EXPECT_EQ(watch.doubt(), "");
}

/// The doubt after 70 pairs of a camera that moves sideways and nods by four degrees, if its focal length (500 px) is
/// said to be this.
std::string doubtAfterADrive(double focal_length) {
  CameraIntrinsics intrinsics = sceneCamera().intrinsics();
  intrinsics.fx = intrinsics.fy = focal_length;
  const Camera camera(intrinsics, sceneCamera().imageSize());
  Drive drive(1, makeStep({0.4, 0, 0}, {4 * M_PI / 180, 0, 0}), true);
  const auto estimator = makeEstimator("lo_prosac", RobustOptions());
  CalibrationWatch watch;
  RobustResult result;
  for (int i = 0; i < 70; ++i) {
    estimator->estimate(drive.advance(), camera, result);
    watch.add(result, camera);
  }
  return watch.doubt();
}

TEST(CalibrationWatch, FindsAFocalLengthThatIsFivePercentOff) {
  EXPECT_EQ(doubtAfterADrive(500), "");
  EXPECT_TRUE(contains(doubtAfterADrive(525), "as if fx and fy were 5 % too large")) << doubtAfterADrive(525);
  EXPECT_TRUE(contains(doubtAfterADrive(475), "as if fx and fy were 5 % too small")) << doubtAfterADrive(475);
}

/// The doubt after 60 pairs of a drawn scene.
std::string doubtAfter(const std::string& name) {
  for (const DrawnScene& scene : drawnScenes()) {
    if (scene.name != name) continue;
    const auto estimator = makeEstimator("lo_prosac", RobustOptions());
    CalibrationWatch watch;
    RobustResult result;
    for (int i = 0; i < kWindow; ++i) {
      Random random(static_cast<uint64_t>(i) + 1);
      TwoViewSceneOptions options = scene.options(random);
      options.seed = random.next();
      const TwoViewScene pair = makeTwoViewScene(options);
      estimator->reset();
      estimator->estimate(pair.pairs, pair.camera, result);
      if (result.pose_found) watch.add(result, pair.camera);
    }
    return watch.doubt();
  }
  throw std::invalid_argument(name);
}

TEST(CalibrationWatch, FindsWhatIsWrongInDrawnScenes) {
  const auto expect = [](const std::string& scene, const std::string& words) {
    const std::string doubt = doubtAfter(scene);
    EXPECT_TRUE(contains(doubt, words)) << scene << ": " << doubt;
  };
  expect("focal_3", "as if fx and fy were 3 % too small:");
  expect("distortion_small", "as if the first coefficient of D were 0.04 too large:");  // it is 0.05
  expect("rolling_straight", "as if ~rolling_shutter_readout were 83 % of the time");   // it is 90 %
}

TEST(CalibrationWatch, WhatMovesByItselfIsNoCalibration) {
  for (const std::string scene : {"general", "body_40_standing", "body_60_turning", "body_60_driving", "crowd_standing",
                                  "crowd_turning", "crowd_driving"}) {
    EXPECT_EQ(doubtAfter(scene), "") << scene;
  }
}

}  // namespace
}  // namespace gms_ransac
