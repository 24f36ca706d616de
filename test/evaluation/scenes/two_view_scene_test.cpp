// The drawn two-view scenes are what they say, by their own truth.
#include "two_view_scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/LU>
#include <opencv2/calib3d.hpp>

#include "scenes/drawn_scenes.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d referenceOf(const TwoViewScene& scene, size_t i) {
  return {scene.pairs.x_reference[i], scene.pairs.y_reference[i]};
}
Vector2d currentOf(const TwoViewScene& scene, size_t i) { return {scene.pairs.x_current[i], scene.pairs.y_current[i]}; }

/// Where the current image shows a point of the reference's frame by the scene's motion, in a camera without error.
Vector2d predicted(const TwoViewScene& scene, size_t i) {
  return (scene.camera.K() * (scene.R * scene.points[i] + scene.t)).hnormalized();
}

double shareOf(const std::vector<int>& labels, int label) {
  return static_cast<double>(std::count(labels.begin(), labels.end(), label)) / static_cast<double>(labels.size());
}

TwoViewSceneOptions clean() {
  TwoViewSceneOptions options;
  options.noise_px = options.outlier_ratio = 0;
  return options;
}

const DrawnScene& named(const std::string& name) {
  const auto& all = drawnScenes();
  return *std::find_if(all.begin(), all.end(), [&](const DrawnScene& scene) { return scene.name == name; });
}

TEST(TwoViewScene, RightMatchesFollowTheMotionThatMostShowAndWrongOnesDoNot) {
  TwoViewSceneOptions outliers = clean(), body = clean(), most = clean(), lens_and_shutter = clean();
  outliers.outlier_ratio = 0.3;
  outliers.outlier_reach = 20;
  body.bodies.resize(1);
  body.bodies[0].share = 0.2;
  body.bodies[0].translation = {0.3, 0, 0};
  most.bodies = lens_and_shutter.bodies = body.bodies;
  most.bodies[0].share = 0.6;
  lens_and_shutter.readout = 0.8;
  lens_and_shutter.acceleration = 0.5;
  lens_and_shutter.radial = {-0.2, 0.05};
  double farthest = 0;
  for (const TwoViewSceneOptions& options : {outliers, body, most, lens_and_shutter}) {
    const TwoViewScene scene = makeTwoViewScene(options);
    const bool ideal = options.readout == 0, body_is_most = !options.bodies.empty() && options.bodies[0].share > 0.5;
    EXPECT_NEAR(shareOf(scene.body, -1), options.outlier_ratio, 0.05);
    for (size_t i = 0; i < scene.points.size(); ++i) {
      const Vector2d error = (currentOf(scene, i) - referenceOf(scene, i) - scene.displacements[i]).cwiseAbs();
      EXPECT_EQ(scene.correct[i] != 0, scene.body[i] == (body_is_most ? 1 : 0));
      if (scene.body[i] == -1) {
        EXPECT_LE(error.maxCoeff(), 20.001);
        farthest = std::max(farthest, error.maxCoeff());
      } else if (!scene.correct[i]) {
        EXPECT_GT(error.norm(), 10);  // 30 cm before or behind it
      } else {
        EXPECT_LT(error.norm(), 1e-3);
        EXPECT_TRUE(!ideal || (currentOf(scene, i) - predicted(scene, i)).norm() < 1e-3);
      }
    }
  }
  EXPECT_GT(farthest, 15);
}

TEST(TwoViewScene, ABodyHasItsShareOfTheViewAndItsOwnMotion) {
  TwoViewSceneOptions options = clean();
  options.translation = options.rotation = Vector3d(0, 0, 0);
  MovingBody body;
  body.share = 0.3;
  body.translation = {0.1, 0.05, -0.1};
  body.rotation = {0, 0.02, 0};
  options.bodies = {body};
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    options.seed = seed;
    const TwoViewScene scene = makeTwoViewScene(options);
    EXPECT_NEAR(shareOf(scene.body, 1), 0.3, 0.06);
    EXPECT_TRUE(scene.R.isIdentity());
    EXPECT_TRUE(scene.t.isZero());
    // Rigid: one motion for all its points, found from them.
    std::vector<Vector2d> places, moved;
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (size_t i = 0; i < scene.points.size(); ++i) {
      EXPECT_EQ(scene.correct[i] != 0, scene.body[i] == 0);
      if (scene.body[i] == 0) {
        EXPECT_LT((currentOf(scene, i) - referenceOf(scene, i)).norm(), 1e-3) << "stands still";
        continue;
      }
      points.emplace_back(scene.points[i].x(), scene.points[i].y(), scene.points[i].z());
      pixels.emplace_back(scene.pairs.x_current[i], scene.pairs.y_current[i]);
      EXPECT_GE(scene.points[i].z(), body.nearest);
      EXPECT_LE(scene.points[i].z(), body.farthest);
    }
    cv::Mat rotation, translation, K;
    cv::eigen2cv(scene.camera.K(), K);
    ASSERT_TRUE(cv::solvePnP(points, pixels, K, cv::noArray(), rotation, translation));
    EXPECT_NEAR(cv::norm(rotation), body.rotation.norm(), 1e-4);
    std::vector<cv::Point2d> again;
    cv::projectPoints(points, rotation, translation, K, cv::noArray(), again);
    for (size_t k = 0; k < again.size(); ++k) EXPECT_LT(cv::norm(again[k] - pixels[k]), 0.02);
  }
}

TEST(TwoViewScene, PlanesHaveTheShareOfPointsOffThemThatIsAskedFor) {
  TwoViewSceneOptions options = clean();
  options.shape = SceneShape::kPlane;
  options.off_plane = 0.1;
  const TwoViewScene scene = makeTwoViewScene(options);
  const auto on_plane = std::count_if(scene.points.begin(), scene.points.end(), [&](const Vector3d& point) {
    return std::abs(scene.plane.dot(point) - 1) < 1e-9;
  });
  EXPECT_NEAR(static_cast<double>(on_plane) / options.matches, 0.9, 0.03);
}

TEST(TwoViewScene, ARollingShutterTurnsEachRowByItsTime) {
  TwoViewSceneOptions options = clean();
  options.translation = {0, 0, 0};
  options.rotation = {0.01, 0.03, 0.02};
  options.readout = 0.8;
  options.acceleration = 0.5;
  const TwoViewScene scene = makeTwoViewScene(options);
  const Matrix3d K = scene.camera.K();
  // Shares of the rotation by s = t (1 + a (t - 1)), where t is 0 and 1 in the middle rows.
  const auto share = [&](double start, double row) {
    const double time = start + options.readout * (row / 480 - 0.5);
    return time * (1 + options.acceleration * (time - 1));
  };
  double largest_effect = 0;
  for (size_t i = 0; i < scene.points.size(); ++i) {
    const Vector2d from = referenceOf(scene, i), to = currentOf(scene, i);
    const Matrix3d turn = rotationFromVector((share(1, to.y()) - share(0, from.y())) * options.rotation);
    EXPECT_LT(((K * turn * scene.points[i]).hnormalized() - to).norm(), 0.01);
    largest_effect = std::max(largest_effect, (predicted(scene, i) - to).norm());
  }
  EXPECT_GT(largest_effect, 3) << "pixels by which a global shutter would differ";
}

TEST(TwoViewScene, AWrongCalibrationIsUndoneByTheTrueOne) {
  TwoViewSceneOptions options = clean();
  options.focal_error = 0.05;
  options.radial = {-0.2, 0.05};
  const TwoViewScene scene = makeTwoViewScene(options);
  CameraIntrinsics lens = scene.camera.intrinsics();
  EXPECT_EQ(lens.fx, 500);
  lens.fx = lens.fy = 525;
  lens.distortion_model = "plumb_bob";
  lens.distortion = {-0.2, 0.05, 0, 0};
  const Camera truth(lens, {640, 480});
  const Matrix3d K = truth.K();
  for (size_t i = 0; i < scene.points.size(); ++i) {
    const cv::Point2f pixel(scene.pairs.x_current[i], scene.pairs.y_current[i]);
    const cv::Point2f ideal = truth.undistort(pixel);
    EXPECT_LT(((K * (scene.R * scene.points[i] + scene.t)).hnormalized() - Vector2d(ideal.x, ideal.y)).norm(), 0.02);
  }
}

TEST(TwoViewScene, DisplacementAndParallaxAreTheMediansThatWereAskedFor) {
  for (const double pixels : {0.1, 1.5, 10.}) {
    EXPECT_NEAR(medianDisplacement(withMedian(medianDisplacement, pixels, {})), pixels, 0.02 * pixels);
    EXPECT_NEAR(medianParallax(withMedian(medianParallax, pixels, {})), pixels, 0.02 * pixels);
  }
  // On a wall before which the camera moves to the side, a rotation undoes nearly all of the displacement.
  TwoViewSceneOptions wall;
  wall.shape = SceneShape::kPlane;
  wall.plane_normal = {0, 0, 1};
  wall.translation = {0.1, 0, 0};
  EXPECT_NEAR(medianDisplacement(wall), 500 * 0.1 / wall.plane_distance, 1e-3);
  EXPECT_LT(medianParallax(wall), 0.2 * medianDisplacement(wall));
}

TEST(DrawnScenes, NamesAreUniqueAndPairsRepeat) {
  std::set<std::string> names;
  for (const DrawnScene& scene : drawnScenes()) {
    EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    EXPECT_FALSE(scene.summary.empty());
    const TwoViewScene first = drawPair(scene, 3), again = drawPair(scene, 3), other = drawPair(scene, 4);
    EXPECT_EQ(first.pairs.x_current, again.pairs.x_current) << scene.name;
    EXPECT_NE(first.pairs.x_current, other.pairs.x_current) << scene.name;
    for (size_t i = 0; i < first.points.size(); ++i) {
      EXPECT_LE(first.pairs.distance[i], first.pairs.second_distance[i]) << scene.name;
      EXPECT_LE(first.pairs.second_distance[i], 256) << scene.name;
      EXPECT_GE(first.pairs.score[i], 1) << scene.name;
    }
  }
}

TEST(DrawnScenes, AreWhatTheirNamesSay) {
  EXPECT_EQ(drawPair(named("few_25"), 0).pairs.size(), 25);
  EXPECT_EQ(drawPair(named("general_2000"), 0).pairs.size(), 2000);
  EXPECT_NEAR(shareOf(drawPair(named("outliers_90"), 0).body, -1), 0.9, 0.04);
  EXPECT_TRUE(drawPair(named("rotation_noise_1.5"), 0).t.isZero());
  EXPECT_TRUE(drawPair(named("body_40_standing"), 0).R.isIdentity());
  EXPECT_NEAR(shareOf(drawPair(named("body_40_standing"), 0).body, 1), 0.4 * 0.9, 0.08);
  const TwoViewScene crowd = drawPair(named("crowd_driving"), 0);
  EXPECT_GT(*std::max_element(crowd.body.begin(), crowd.body.end()), 8);
  EXPECT_NEAR(shareOf(drawPair(named("repeated_40"), 0).body, 1), 0.4 * 0.9, 0.06);
  const TwoViewScene near = drawPair(named("near_epipole"), 0);
  const auto x = std::minmax_element(near.pairs.x_reference.begin(), near.pairs.x_reference.end());
  EXPECT_GT(*x.first, 200);
  EXPECT_LT(*x.second, 440);
}

}  // namespace
}  // namespace gms_ransac
