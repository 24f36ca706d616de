// A calibration is doubted while most pairs contradict the camera model in the same way, and only then.
#include "node/calibration_watch.h"

#include <string>

#include <gtest/gtest.h>

#include "drive_scene.h"
#include "says.h"
#include "scenes/drawn_scenes.h"

namespace gms_ransac {
namespace {

constexpr int kWindow = static_cast<int>(CalibrationWatch::kPairs);

std::shared_ptr<const CameraModel> model(const Camera& camera) {
  auto made = std::make_shared<CameraModel>();
  made->camera = camera;
  made->source = "the parameters ~camera";
  return made;
}

/// Pairs that know one error to a tenth: half a tenth more and half a tenth less, one after the other.
void add(int pairs, double misfit, CameraErrors::Parameter parameter, double error, CalibrationWatch& watch) {
  static const auto camera = model(sceneCamera());
  for (int i = 0; i < pairs; ++i) {
    RobustResult result;
    result.camera_misfit = misfit;
    result.camera_errors.value[parameter] = error * (i % 2 ? 1.05 : 0.95);
    result.camera_errors.information[parameter] = 100 / (error * error);
    watch.add(result, camera);
  }
}

TEST(CalibrationWatch, NamesTheCorrectionAndWhereTheCalibrationIsFrom) {
  struct Case {
    CameraErrors::Parameter parameter;
    double error;
    const char* seems;
    const char* remedy;
  };
  for (const Case& c :
       {Case{CameraErrors::kFocalLength, 0.05, "fx and fy were 5 % too large", "fx and fy of the parameters ~camera"},
        Case{CameraErrors::kPrincipalX, 0.04, "cx were 20 px too large", "cx and cy of the parameters ~camera"},
        Case{CameraErrors::kPrincipalY, -0.04, "cy were 20 px too small", "cx and cy of the parameters ~camera"},
        Case{CameraErrors::kRadial, 0.05, "the first distortion coefficient were 0.05 too large",
             "the parameters ~camera says that the images have no distortion"},
        Case{CameraErrors::kReadoutRotation, -0.5,
             "~rolling_shutter_readout were 48 % of the time from image to image too short", "global shutter"}}) {
    CalibrationWatch watch;
    add(kWindow - 31, 0.5, c.parameter, c.error, watch);
    add(30, 3, c.parameter, c.error, watch);
    EXPECT_EQ(watch.doubt(), "") << "59 pairs are too few";
    add(1, 3, c.parameter, c.error, watch);
    EXPECT_TRUE(says(watch.doubt(), {"31 of the last 60 pairs contradict the camera model", c.seems, c.remedy}));
    add(1, 0.5, c.parameter, c.error, watch);
    add(30, 3, c.parameter, c.error, watch);
    watch.add(RobustResult(), model(sceneCamera()));
    EXPECT_EQ(watch.doubt(), "") << "another camera";
  }
}

TEST(CalibrationWatch, NeedsMostPairsOneSignAndAnErrorThatMatters) {
  const auto doubt = [](auto&& fill) {
    CalibrationWatch watch;
    fill(watch);
    return watch.doubt();
  };
  const auto focal = CameraErrors::kFocalLength, readout = CameraErrors::kReadoutRotation;
  EXPECT_EQ(doubt([&](auto& watch) { add(30, 3, focal, 0.05, watch), add(30, 0.5, focal, 0.05, watch); }), "");
  EXPECT_EQ(doubt([&](auto& watch) {
              for (int i = 0; i < 6; ++i) add(10, 30, focal, i == 2 ? -0.05 : 0.05, watch);
            }),
            "");
  EXPECT_EQ(doubt([&](auto& watch) { add(kWindow, 30, focal, 0.01, watch); }), "");
  EXPECT_EQ(doubt([&](auto& watch) { add(kWindow, 30, readout, -2, watch); }), "") << "longer than the period";
  EXPECT_EQ(doubt([&](auto& watch) { add(kWindow, 30, readout, 0.5, watch); }), "") << "backwards";
}

TEST(CalibrationWatch, NamesCausesThatCannotBeToldApart) {
  CalibrationWatch watch;
  const auto camera = model(sceneCamera());
  for (int i = 0; i < kWindow; ++i) {
    RobustResult result;
    result.camera_misfit = 3;
    for (const auto& [parameter, error] :
         {std::pair(CameraErrors::kRadial, -0.03), {CameraErrors::kReadoutRotation, -0.5}}) {
      result.camera_errors.value[parameter] = error * (i % 2 ? 1.05 : 0.95);
      result.camera_errors.information[parameter] = 100 / (error * error);
    }
    watch.add(result, camera);
  }
  EXPECT_TRUE(says(watch.doubt(), {"the first distortion coefficient were 0.03 too small, or ~rolling_shutter_readout",
                                   "these images cannot tell which"}));
}

/// The doubt after 60 pairs of a drawn scene.
std::string doubtAfter(const DrawnScene& scene) {
  const auto estimator = makeEstimator("lo_prosac", RobustOptions());
  CalibrationWatch watch;
  std::shared_ptr<const CameraModel> camera;
  RobustResult result;
  for (int i = 0; i < kWindow; ++i) {
    Random random(static_cast<uint64_t>(i) + 1);
    TwoViewSceneOptions options = scene.options(random);
    options.seed = random.next();
    const TwoViewScene pair = makeTwoViewScene(options);
    if (!camera) camera = model(pair.camera);
    estimator->estimate(pair.pairs, pair.camera, result);
    if (result.pose_found) watch.add(result, camera);
  }
  return watch.doubt();
}

TEST(CalibrationWatch, InDrawnScenesAWrongCalibrationIsNamedAndMovingObjectsAreNone) {
  const std::map<std::string, std::vector<std::string>> expected = {
      {"focal_3", {"as if fx and fy were 3 % too small:"}},
      {"distortion_small", {"as if the first distortion coefficient were 0.04 too large:"}},  // it is 0.05
      {"rolling_straight", {"as if ~rolling_shutter_readout were 82 % of the time"}},         // it is 90 %
      {"general", {}},
      {"body_60_turning", {}},
      {"body_60_driving", {}},
      {"crowd_driving", {}}};
  size_t seen = 0;
  for (const DrawnScene& scene : drawnScenes()) {
    const auto words = expected.find(scene.name);
    if (words == expected.end()) continue;
    ++seen;
    SCOPED_TRACE(scene.name);
    EXPECT_TRUE(says(doubtAfter(scene), words->second));
  }
  EXPECT_EQ(seen, expected.size());
}

}  // namespace
}  // namespace gms_ransac
