// camera_info -> camera: region of interest, binning, every distortion model, K or P, and what is refused with a
// sentence.
#include "input/camera_model.h"

#include <functional>
#include <limits>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>
#include <opencv2/calib3d.hpp>

#include "camera/distortion.h"
#include "says.h"

namespace gms_ransac {
namespace {

sensor_msgs::CameraInfo calibrated(uint32_t width = 640, uint32_t height = 480) {
  sensor_msgs::CameraInfo info;
  info.width = width;
  info.height = height;
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0);
  info.K = {500, 0, 321, 0, 502, 243, 0, 0, 1};
  info.P = {480, 0, 310, 0, 0, 481, 250, 0, 0, 0, 1, 0};
  return info;
}

std::shared_ptr<const CameraModel> model(const sensor_msgs::CameraInfo& info, cv::Size size,
                                         Rectified rectified = Rectified::kFalse, const std::string& topic = "/image",
                                         const CameraIntrinsics& override = {}) {
  Parameters parameters;
  parameters.input_is_rectified = rectified;
  parameters.camera = override;
  return CameraModelSource(parameters, topic, "/camera_info")
      .get(boost::make_shared<sensor_msgs::CameraInfo>(info), size);
}

void expectIntrinsics(const CameraModel& model, double fx, double fy, double cx, double cy) {
  ASSERT_EQ(model.problem, "");
  const CameraIntrinsics& k = model.camera.intrinsics();
  EXPECT_DOUBLE_EQ(k.fx, fx);
  EXPECT_DOUBLE_EQ(k.fy, fy);
  EXPECT_DOUBLE_EQ(k.cx, cx);
  EXPECT_DOUBLE_EQ(k.cy, cy);
}

sensor_msgs::CameraInfo cropped() {
  sensor_msgs::CameraInfo info = calibrated();
  info.roi.x_offset = 100;
  info.roi.y_offset = 60;
  info.roi.width = 400;
  info.roi.height = 300;
  return info;
}

/// In a raw bag by kitti2bag the images are rectified, but K and D are those of the raw ones.
TEST(CameraModel, DoubtsThatKDescribesACroppedImage) {
  sensor_msgs::CameraInfo info = calibrated(1242, 375);
  info.D = {-0.37, 0.2, 0.001, 0.002, -0.07};
  info.K = {984.2, 0, 690, 0, 980.8, 233.2, 0, 0, 1};
  info.P = {721.5, 0, 609.6, 0, 0, 721.5, 172.9, 0, 0, 0, 1, 0};
  const std::vector<std::string> doubt = {"12 % of the image from its centre, that in P 3.9 %", "~input_is_rectified"};
  EXPECT_TRUE(says(model(info, {1242, 375}, Rectified::kAuto)->doubt, doubt));
  EXPECT_EQ(model(info, {1242, 375}, Rectified::kTrue)->doubt, "");
  EXPECT_EQ(model(info, {1242, 375}, Rectified::kFalse)->doubt, "");
  info.K[2] = 630;
  info.K[5] = 190;
  EXPECT_EQ(model(info, {1242, 375}, Rectified::kAuto)->doubt, "");
}

TEST(CameraModel, CutsTheRegionOfInterestThenBins) {
  const struct {
    sensor_msgs::CameraInfo info;
    uint32_t binning_x, binning_y;
    cv::Size size;
    Rectified rectified;
    double fx, fy, cx, cy;
  } rows[] = {{cropped(), 0, 0, {400, 300}, Rectified::kFalse, 500, 502, 221, 183},
              {cropped(), 0, 0, {400, 300}, Rectified::kTrue, 480, 481, 210, 190},
              {calibrated(), 2, 4, {320, 120}, Rectified::kFalse, 250, 125.5, 160.5, 60.75},
              {cropped(), 2, 2, {200, 150}, Rectified::kFalse, 250, 251, 110.5, 91.5}};
  for (auto row : rows) {
    row.info.binning_x = row.binning_x;
    row.info.binning_y = row.binning_y;
    expectIntrinsics(*model(row.info, row.size, row.rectified), row.fx, row.fy, row.cx, row.cy);
  }
}

TEST(CameraModel, RefusesWithASentence) {
  using Info = sensor_msgs::CameraInfo;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto focal = [](double fx, double fy, double px) {
    return [=](Info& info) {
      info.K[0] = fx;
      info.K[4] = fy;
      info.P[0] = px;
    };
  };
  const auto distortion = [](const std::string& name, std::vector<double> coefficients) {
    return [=](Info& info) {
      info.distortion_model = name;
      info.D = coefficients;
    };
  };
  const auto corner = [](Info& info) { info.K[2] = info.K[5] = info.P[2] = info.P[6] = 0; };
  const struct {
    std::function<void(Info&)> spoil;
    Rectified rectified;
    const char* words;
  } rows[] = {{[](Info& info) { info.binning_x = info.binning_y = 2; }, Rectified::kFalse,
               "on /camera_info is for 320x240 images, but the image is 640x480"},
              {[](Info& info) {
                 info.width = 0x80000000;
                 info.binning_x = 0xffffffff;
               },
               Rectified::kFalse, "but the image is 640x480"},
              {distortion("stereographic", {0.1, 0.1, 0, 0, 0}), Rectified::kFalse, "stereographic"},
              {distortion("plumb_bob", std::vector<double>(7, 0.1)), Rectified::kFalse, "not 7"},
              {distortion("plumb_bob", {nan, inf, 0, 0, 0}), Rectified::kFalse, "finite"},
              {[](Info& info) {
                 info.K[0] = info.K[4] = info.P[0] = info.P[5] = std::numeric_limits<double>::denorm_min();
                 info.binning_x = info.binning_y = 4;
                 info.width = info.height = 0;
               },
               Rectified::kFalse, "fx and fy are 0 after binning"},
              {focal(nan, 500, 500), Rectified::kAuto, "fx is nan and fy is 500 in K"},
              {focal(-500, 500, 500), Rectified::kAuto, "fx is -500 and fy is 500 in K"},
              {focal(500, 0, 500), Rectified::kAuto, "fx is 500 and fy is 0 in K"},
              {focal(500, 500, -480), Rectified::kAuto, "fx is -480 and fy is 481 in P"},
              {focal(inf, 500, 500), Rectified::kAuto, "inf"},
              {corner, Rectified::kFalse, "cx and cy are 0 in K"},
              {corner, Rectified::kTrue, "cx and cy are 0 in P"}};
  for (const auto& row : rows) {
    Info info = calibrated();
    row.spoil(info);
    const auto refused = model(info, {640, 480}, row.rectified);
    EXPECT_FALSE(refused->camera.calibrated()) << row.words;
    EXPECT_TRUE(says(refused->problem, {"the camera_info on /camera_info", row.words}));
  }
  Info info = calibrated();
  info.K[2] = info.P[2] = 0;
  EXPECT_EQ(model(info, {640, 480})->problem, "") << "only both";
}

/// Undistorted pixels of the model against OpenCV's, on a grid over a 640x480 image.
template <typename Reference>
void expectUndistorts(const CameraModel& model, const Reference& reference) {
  ASSERT_EQ(model.problem, "");
  EXPECT_FALSE(model.rectified());
  std::vector<cv::Point2d> pixels, expected;
  for (double y = 20; y <= 460; y += 20) {
    for (double x = 20; x <= 620; x += 20) pixels.emplace_back(x, y);
  }
  reference(pixels, expected);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const cv::Point2f got = model.camera.undistort(cv::Point2f(pixels[i]));
    EXPECT_NEAR(got.x, expected[i].x, 0.01) << pixels[i];
    EXPECT_NEAR(got.y, expected[i].y, 0.01) << pixels[i];
  }
}

const cv::Matx33d kMatrix(500, 0, 321, 0, 502, 243, 0, 0, 1);

TEST(CameraModel, UndistortsLikeOpenCvByEitherNameOfAModel) {
  const struct {
    const char* name;
    std::vector<double> D;
  } rows[] = {{"plumb_bob", {-0.28, 0.074, 0.0002, 0.00002, 0}},
              {"radtan", {-0.28, 0.074, 0.0002, 0.00002}},
              {"equidistant", {-0.0066, 0.044, -0.042, 0.0077}},
              {"fisheye", {-0.0066, 0.044, -0.042, 0.0077}}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    sensor_msgs::CameraInfo info = calibrated();
    info.distortion_model = row.name;
    info.D = row.D;
    expectUndistorts(*model(info, {640, 480}, Rectified::kAuto), [&](const auto& pixels, auto& expected) {
      if (commonModelName(row.name) == "equidistant") {
        cv::fisheye::undistortPoints(pixels, expected, kMatrix, info.D, cv::noArray(), kMatrix);
      } else {
        cv::undistortPoints(pixels, expected, kMatrix, info.D, cv::noArray(), kMatrix,
                            cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10));
      }
    });
  }
}

TEST(CameraModel, QuotesAMessageInPart) {
  sensor_msgs::CameraInfo info = calibrated();
  info.distortion_model = std::string(100000, 'x') + "\n\x1b[2J";
  info.D.assign(1000000, 0.1);
  const auto refused = model(info, {640, 480});
  EXPECT_FALSE(refused->camera.calibrated());
  EXPECT_LT(refused->problem.size(), 500U);
}

TEST(CameraModel, SaysOnceHowManyPixelsHaveNoRay) {
  sensor_msgs::CameraInfo info = calibrated();
  info.D = {-0.4, 0, 0, 0, 0};
  info.K = {250, 0, 320, 0, 250, 240, 0, 0, 1};
  CameraModelSource source(Parameters(), "/image", "/camera_info");
  const auto message = boost::make_shared<sensor_msgs::CameraInfo>(info);
  const auto folding = source.get(message, {640, 480});
  const std::string pixels = std::to_string(folding->camera.pixelsWithoutInverse()) + " pixels (76 %)";
  EXPECT_TRUE(says(folding->warning, {pixels}));
  EXPECT_EQ(source.get(message, {640, 480}), folding) << "made, and its warning logged, but once";
  info.D = {-0.4, 0.15, 0, 0, 0};
  EXPECT_EQ(source.get(boost::make_shared<sensor_msgs::CameraInfo>(info), {640, 480})->warning, "");
}

TEST(CameraModel, AFisheyeLensWithoutCoefficientsIsNoPinhole) {
  sensor_msgs::CameraInfo info = calibrated();
  info.distortion_model = "equidistant";
  info.D.assign(4, 0);
  const auto raw = model(info, {640, 480}, Rectified::kAuto);
  EXPECT_FALSE(raw->rectified());
  EXPECT_NEAR(raw->camera.undistort({621, 243}).x, 321 + 500 * std::tan(300 / 500.0), 0.01);
}

TEST(CameraModel, RectifiedImagesAreDescribedByP) {
  sensor_msgs::CameraInfo info = calibrated();
  info.D = {0.1, 0, 0, 0, 0};
  expectIntrinsics(*model(info, {640, 480}, Rectified::kAuto, "/camera/image_rect"), 480, 481, 310, 250);
  expectIntrinsics(*model(info, {640, 480}, Rectified::kAuto, "/direct/image_raw"), 500, 502, 321, 243);
  info.K.fill(0);  // as kitti2bag leaves it
  const auto from_p = model(info, {640, 480}, Rectified::kAuto, "/kitti/image_raw");
  expectIntrinsics(*from_p, 480, 481, 310, 250);
  EXPECT_TRUE(from_p->rectified());
}

TEST(CameraModel, DoubtsValuesThatACameraSeldomHas) {
  using Info = sensor_msgs::CameraInfo;
  // Freiburg 1 of TUM, whose factory value is 525.
  const CameraIntrinsics desk = {517.306408, 516.469215,  318.643040,
                                 255.313989, "plumb_bob", {0.26, -0.95, -0.005, 0.003, 1.16}};
  const auto info = [](uint32_t width, uint32_t height, double f,
                       const std::vector<std::function<void(Info&)>>& changes = {}) {
    Info info = calibrated(width, height);
    info.K[0] = info.K[4] = info.P[0] = info.P[5] = f;
    if (width > 0) {
      info.K[2] = info.P[2] = 0.5 * width;
      info.K[5] = info.P[6] = 0.5 * height;
    }
    for (const auto& change : changes) change(info);
    return info;
  };
  const auto of_p = [](Info& info) { info.K.fill(0); };
  const auto kinect = [](Info& info) { info.K = {525, 0, 319.5, 0, 525, 239.5, 0, 0, 1}; };
  const auto oblong = [](Info& info) { info.K[4] = 9842; };
  const auto distorted = [](Info& info) { info.D[0] = 0.2; };
  const auto without_coefficients = [](Info& info) { info.D.clear(); };
  const auto binned = [](Info& info) { info.binning_x = info.binning_y = 2; };
  const auto narrow = [](Info& info) { info.binning_x = 2; };
  const auto all_of_a_wide_lens = [](Info& info) { info.P[0] = info.P[5] = 400; };
  const struct {
    CameraIntrinsics camera;
    Info info;
    cv::Size size;
    std::vector<std::string> words;
  } rows[] = {
      {{},
       info(640, 480, 525, {kinect}),
       {640, 480},
       {"camera_info on /camera_info holds the factory values", "calibration:=1, 2 or 3"}},
      {{}, info(640, 480, 525, {kinect, distorted}), {640, 480}, {}},
      {{}, info(640, 480, 525, {kinect, without_coefficients}), {640, 480}, {}},  // of a rendered scene
      {{}, info(640, 480, 500), {640, 480}, {}},
      {{}, info(1280, 720, 12572, {oblong}), {1280, 720}, {"fx 12572 and fy 9842"}},
      {{}, info(1280, 720, 12572, {oblong, narrow}), {640, 720}, {}},
      // Another camera than that of the parameters.
      {desk, info(1226, 370, 707.0912, {of_p}), {1226, 370}, {"~camera", "fx 517.306", "/camera_info", "fx 707.091"}},
      {desk, info(1280, 960, 500), {640, 480}, {"is for 1280x960 images, but the image is 640x480"}},
      // Another calibration of the same camera.
      {desk, info(640, 480, 500), {640, 480}, {}},
      {desk, info(640, 480, 525), {640, 480}, {}},
      {desk, info(640, 480, 525, {all_of_a_wide_lens}), {640, 480}, {}},
      {desk, info(1280, 960, 1030, {binned}), {640, 480}, {}},
      // Says nothing, and says no size.
      {desk, info(640, 480, 0), {640, 480}, {}},
      {desk, info(0, 0, 500), {640, 480}, {}}};
  for (const auto& row : rows) {
    const auto made = model(row.info, row.size, Rectified::kAuto, "/image", row.camera);
    EXPECT_EQ(made->problem, "");
    EXPECT_TRUE(says(made->doubt, row.words));
    EXPECT_EQ(made->source, row.camera.calibrated() ? "the parameters ~camera" : "the camera_info on /camera_info");
    if (!row.camera.calibrated()) continue;
    EXPECT_EQ(made->camera.intrinsics().fx, desk.fx) << "the parameters count";
  }
}

/// Matrices of another size, or with binning or region counted twice or not at all.
TEST(CameraModel, DoubtsAMatrixThatNoCameraHas) {
  using Info = sensor_msgs::CameraInfo;
  const auto info = [](uint32_t width, uint32_t height, double f, double cx, double cy) {
    Info info;
    info.width = width;
    info.height = height;
    info.distortion_model = "plumb_bob";
    info.K = {f, 0, cx, 0, f, cy, 0, 0, 1};
    return info;
  };
  const auto binned = [](Info info, uint32_t by) {
    info.binning_x = info.binning_y = by;
    return info;
  };
  const auto region = [](Info info, uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
    info.roi.x_offset = x;
    info.roi.y_offset = y;
    info.roi.width = width;
    info.roi.height = height;
    return info;
  };
  const cv::Size vga(640, 480);
  const struct {
    const char* what;
    Info info;
    cv::Size size;
    std::vector<std::string> words;
  } rows[] = {
      {"right", info(640, 480, 500, 320, 240), vga, {}},
      {"binning counted twice",
       binned(info(1280, 960, 500, 320, 240), 2),
       vga,
       {"at 25 % of the width and 25 % of the height of the 640x480 image by the camera_info on /camera_info",
        "binning 2x2, region of interest 0x0 at 0, 0"}},
      {"binning not counted", info(640, 480, 1000, 640, 480), vga, {"at 100 % of the width"}},
      {"binning counted once", binned(info(1280, 960, 1000, 640, 480), 2), vga, {}},
      {"another resolution", info(0, 0, 1000, 627, 470), vga, {"at 98 % of the width and 97.9 % of the height"}},
      {"region in a corner", region(info(640, 480, 500, 320, 240), 400, 300, 200, 150), {200, 150}, {}},
      {"region counted twice",
       region(info(640, 480, 500, 120, 90), 200, 150, 400, 300),
       {400, 300},
       {"at 18.8 % of the width", "640x480 image", "region of interest 400x300 at 200, 150"}},
      {"region not counted",
       info(400, 300, 500, 120, 240),
       {400, 300},
       {"at 30 % of the width and 80 % of the height"}},
      {"region, binned", binned(region(info(640, 480, 500, 320, 240), 400, 300, 200, 150), 2), {100, 75}, {}},
      {"turned",
       info(480, 640, 500, 320, 240),
       {480, 640},
       {"at 66.7 % of the width", "the images were turned by 90 degrees, and so must be K"}},
      {"normalised", info(640, 480, 1.2, 0.5, 0.5), vga, {"the focal length is 1.2 pixels", "in pixels of this size"}},
      {"millimetres", info(640, 480, 4, 320, 240), vga, {"the focal length is 4 pixels"}},
      {"micrometres", info(640, 480, 40000, 320, 240), vga, {"the focal length is 4e+04 pixels"}},
      {"a long lens", info(640, 480, 15000, 330, 230), vga, {}},
      {"a wide one", info(640, 480, 120, 330, 230), vga, {}}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.what);
    EXPECT_TRUE(says(model(row.info, row.size)->doubt, row.words));
    // The same by ~camera, which is that of the received image.
    if (row.info.binning_x > 1 || row.info.roi.width > 0) continue;
    const CameraIntrinsics k = {row.info.K[0], row.info.K[4], row.info.K[2], row.info.K[5], "", {}};
    Parameters parameters;
    parameters.camera = k;
    const auto given = CameraModelSource(parameters, "/image", "/camera_info").get(nullptr, row.size);
    EXPECT_EQ(given->doubt.empty(), row.words.empty()) << given->doubt;
    EXPECT_TRUE(row.words.empty() || says(given->doubt, {"by the parameters ~camera"}));
  }
}

}  // namespace
}  // namespace gms_ransac
