// The rendered scene against itself: its exact values are exact, and its pictures have texture to match.
#include "scenes/scene.h"

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "rendered_scene.h"

namespace gms_ransac {
namespace {

SceneOptions noiseless(const std::string& scene) {
  SceneOptions options;
  options.scene = scene;
  options.noise = 0;
  options.blur = 0;
  return options;
}

const Scene& room() {
  static const Scene scene(noiseless("room"));
  return scene;
}

float bilinear(const cv::Mat& image, const cv::Point2d& p) {
  cv::Mat_<uint8_t> value;
  cv::getRectSubPix(image, {1, 1}, cv::Point2f(p), value);
  return value(0, 0);
}

TEST(Scene, SameOptionsGiveTheSameFrame) {
  SceneOptions options;
  options.size = {320, 240};
  const RenderedFrame a = Scene(options).render(7), b = Scene(options).render(7);
  EXPECT_EQ(cv::norm(a.image, b.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(a.depth, b.depth, cv::NORM_INF), 0);
  options.seed = 1;
  EXPECT_GT(cv::norm(a.image, Scene(options).render(7).image, cv::NORM_L1) / a.image.total(), 5);
}

TEST(Scene, DepthAndPoseLeadToTheSameTextureAndHiddenPointsNowhere) {
  // A point seen in both frames has the same grey value in both, but for resampling: compared with a random shift.
  const int i = 30, j = 38;
  const RenderedFrame a = room().render(i), b = room().render(j);
  const Eigen::Isometry3d to_b = b.camera_pose.inverse() * a.camera_pose;
  const CameraIntrinsics& k = room().intrinsics();
  double matched = 0, shifted = 0;
  int count = 0, hidden = 0;
  for (int y = 10; y < 470; y += 5) {
    for (int x = 10; x < 630; x += 5) {
      const double z = a.depth(y, x);
      const Eigen::Vector3d p = to_b * Eigen::Vector3d((x - k.cx) / k.fx * z, (y - k.cy) / k.fy * z, z);
      const cv::Point2d q = room().project(p);
      cv::Point2d exact, back;
      const bool visible = room().correspondence(i, cv::Point2d(x, y), j, exact);
      if (cv::Rect(1, 1, 637, 477).contains(q)) {
        // The depth image has pixel centres only: at the rim of what hides the point all four around it must agree.
        double farthest = 0;
        cv::minMaxLoc(b.depth(cv::Rect(cvFloor(q.x), cvFloor(q.y), 2, 2)), nullptr, &farthest);
        hidden += farthest < 0.9 * p.z();
        EXPECT_FALSE(visible && farthest < 0.9 * p.z()) << x << ", " << y;
      }
      if (!visible) continue;
      EXPECT_LT(cv::norm(exact - q), 2e-3);
      ASSERT_TRUE(room().correspondence(j, exact, i, back));
      EXPECT_LT(cv::norm(back - cv::Point2d(x, y)), 1e-6);
      const float grey = a.image.at<uint8_t>(y, x);
      matched += std::abs(grey - bilinear(b.image, q));
      shifted += std::abs(grey - bilinear(b.image, q + cv::Point2d(6, 6)));
      ++count;
    }
  }
  EXPECT_GT(count, 4500);
  EXPECT_GT(hidden, 20);
  EXPECT_LT(matched / count, 7);
  EXPECT_GT(shifted / count, 3 * matched / count);
}

TEST(Scene, DistortionIsOpenCvs) {
  SceneOptions options = noiseless("room");
  options.size = {320, 240};
  options.distortion = {0.262383, -0.953104, -0.005358, 0.002628, 1.163314};  // TUM freiburg1
  const Scene scene(options);
  const CameraIntrinsics& k = scene.intrinsics();
  const cv::Matx33d K(k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1);
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.9, -0.6, 2), Eigen::Vector3d(-1.1, 0.2, 2.1)}) {
    std::vector<cv::Point2d> expected;
    cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(), cv::Vec3d(), K, options.distortion,
                      expected);
    EXPECT_LT(cv::norm(scene.project(p) - expected[0]), 1e-9);
  }
  // The same surface point, seen with and without the lens.
  SceneOptions ideal = options;
  ideal.distortion.clear();
  const Scene pinhole(ideal);
  const cv::Point2d pixel(280, 30);
  const double depth = scene.depth(2, pixel);
  std::vector<cv::Point2d> undistorted;
  cv::undistortPoints(std::vector<cv::Point2d>{pixel}, undistorted, K, options.distortion, cv::noArray(), K,
                      cv::TermCriteria(cv::TermCriteria::COUNT, 100, 0));
  EXPECT_GT(cv::norm(undistorted[0] - pixel), 1);
  EXPECT_NEAR(pinhole.depth(2, undistorted[0]), depth, 1e-6 * depth);
}

TEST(Scene, MotionIsSmoothAndOfTheAskedStep) {
  for (const char* name : {"room", "street"}) {
    SceneOptions options = noiseless(name);
    options.size = {64, 48};
    const Scene scene(options);
    const double step = scene.options().step;
    for (int i = 0; i < 300; ++i) {
      const RelativePose motion = trueRelativePose(scene, i, i + 1);
      EXPECT_NEAR(motion.t.norm(), step, 0.25 * step);
      EXPECT_LT(Eigen::AngleAxisd(motion.R).angle() * 180 / M_PI, 2);
      EXPECT_TRUE(motion.R.isUnitary(1e-12) && motion.R.determinant() > 0);
    }
  }
}

SceneOptions standing(double turn) {
  SceneOptions options = noiseless("room");
  options.step = options.sway = 0;
  options.turn = turn;
  return options;
}

TEST(Scene, MoversMoveByThemselvesAndAreWhereTheirPictureIs) {
  SceneOptions options = standing(0);
  const Scene empty(options);
  options.movers = 2;
  const Scene scene(options);
  const int i = 4, j = 10;
  const RenderedFrame a = scene.render(i), b = scene.render(j);
  int moved = 0;
  double difference = 0, shifted = 0;
  for (int y = 9; y < 480; y += 10) {
    for (int x = 9; x < 640; x += 10) {
      const cv::Point2d pixel(x, y);
      cv::Point2d position;
      const bool mover = scene.depth(i, pixel) < empty.depth(i, pixel) - 1e-6;
      EXPECT_NEAR(a.depth(y, x), scene.depth(i, pixel), 1e-4 * scene.depth(i, pixel)) << pixel;
      if (!scene.correspondence(i, pixel, j, position)) continue;
      EXPECT_EQ(cv::norm(position - pixel) > 1e-6, mover) << pixel;
      if (!mover) continue;
      ++moved;
      difference += std::abs(bilinear(a.image, pixel) - bilinear(b.image, position));
      shifted += std::abs(bilinear(a.image, pixel) - bilinear(b.image, pixel));
    }
  }
  EXPECT_GT(moved, 100);
  EXPECT_LT(difference, 0.5 * shifted);
}

TEST(Scene, EachRowOfARollingShutterIsThatOfItsTime) {
  SceneOptions options = standing(4);
  options.readout = 0.8;
  const RenderedFrame rolling = Scene(options).render(1);
  for (const int row : {0, 120, 400}) {
    // A global shutter at frame 1, with the rotation that the other camera has when it reads this row.
    const SceneOptions same_heading = standing(4 * (1 + options.readout * ((row + 0.5) / 480 - 0.5)));
    const RenderedFrame instant = Scene(same_heading).render(1);
    EXPECT_LT(cv::norm(rolling.depth.row(row), instant.depth.row(row), cv::NORM_INF), 1e-4) << row;
    EXPECT_GT(cv::norm(rolling.depth.row(row), instant.depth.row(row + (row < 200 ? 40 : -40)), cv::NORM_INF), 1e-2);
  }
}

TEST(Scene, AnOpenShutterBlursWhatMoves) {
  const auto sharpness = [](const SceneOptions& options) {
    cv::Mat edges;
    cv::Laplacian(Scene(options).render(2).image, edges, CV_32F);
    return cv::norm(edges);
  };
  SceneOptions options = standing(0);
  const double at_rest = sharpness(options);
  options.exposure = 0.5;
  EXPECT_NEAR(sharpness(options), at_rest, 0.01 * at_rest) << "what stands still stays sharp";
  options.turn = 2;
  const double blurred = sharpness(options);
  options.exposure = 0;
  EXPECT_LT(blurred, 0.5 * sharpness(options));
}

TEST(Scene, TexturesRepeatAndImagesDarken) {
  SceneOptions options = standing(0);
  options.size = {320, 240};
  const cv::Mat plain = Scene(options).render(0).image;
  options.brightness = 0.25;
  EXPECT_NEAR(cv::mean(Scene(options).render(0).image)[0], 0.25 * cv::mean(plain)[0], 1);
  options.brightness = 1;
  options.repetition = 1.5;
  EXPECT_GT(cv::norm(plain, Scene(options).render(0).image, cv::NORM_L1) / plain.total(), 5);
}

TEST(Scene, RefusesNonsense) {
  SceneOptions moon, tiny, lens, options;
  moon.scene = "moon";
  tiny.size = {4, 4};
  lens.distortion = {0.1, 0.2};
  for (const SceneOptions& bad : {moon, tiny, lens}) EXPECT_THROW(Scene{bad}, std::invalid_argument);
  options.scene = "street";
  options.size = {64, 48};
  const Scene street(options);
  EXPECT_NO_THROW(street.pose(street.frameCount() - 1));
  EXPECT_THROW(street.pose(street.frameCount()), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
