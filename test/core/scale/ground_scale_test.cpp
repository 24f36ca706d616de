// Length from the camera's height: on exact scenes, with things that stand on the ground, without any ground, and on
// KITTI 06 through the whole pipeline.
#include "scale/ground_scale.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "datasets/dataset.h"
#include "frame_pairs.h"
#include "percentile.h"
#include "scenes/two_view_scene.h"
#include "shared_data.h"
#include "support/random.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

constexpr double kPixel = 1.0 / 500, kCameraHeight = 1.65;
constexpr double kDegree = 3.14159265358979323846 / 180;
const GroundPrior kLevel = {kCameraHeight};  // of a camera held level

/// A camera that drives 0.8 m over a plane and sees it, and what stands on it.
class DrivingScene {
 public:
  explicit DrivingScene(double pitch = 0, double noise_px = 0) : noise_(noise_px) {
    down_ = {0, std::cos(pitch), std::sin(pitch)};
    forward_ = {0, -std::sin(pitch), std::cos(pitch)};
    pose.R = rotationFromVector({0.002, 0.01, -0.003});
    pose.t = pose.R * forward_;  // along the ground as the current camera has it
  }
  /// Points of the ground, from so near to so far, metres.
  void addGround(int count, double near = 4, double far = 30) {
    for (int i = 0; i < count; ++i) {
      const double ahead = near + (far - near) * random_.uniform(), side = 8 * random_.uniform() - 4;
      add(kCameraHeight * down_ + ahead * forward_ + side * Eigen::Vector3d::UnitX());
    }
  }
  /// Points of a wall next to the road, or of things on it.
  void addWall(int count, double side) {
    for (int i = 0; i < count; ++i) {
      const double ahead = 4 + 26 * random_.uniform(), up = 5 * random_.uniform() - kCameraHeight;
      add(-up * down_ + ahead * forward_ + side * Eigen::Vector3d::UnitX());
    }
  }
  Ground measure(const GroundPrior& prior) {
    triangulate(pose, 0, points_);
    return measureGround(points_, pose, sceneCamera(), prior);
  }
  GroundPrior prior(double down_error = 0, double down_sigma = 0.17) const {
    GroundPrior prior;
    prior.camera_height = kCameraHeight;
    prior.down = rotationFromVector({down_error, 0, 0}) * down_;
    prior.down_sigma = down_sigma;
    return prior;
  }

  static constexpr double kLength = 0.8;
  RelativePose pose;

 private:
  void add(const Eigen::Vector3d& current) {
    const Eigen::Vector3d reference = pose.R * current + kLength * pose.t;
    points_.row.push_back(points_.size());
    const auto off = [this] { return noise_ * kPixel * gaussian(random_); };
    points_.x_reference.push_back(reference.x() / reference.z() + off());
    points_.y_reference.push_back(reference.y() / reference.z() + off());
    points_.x_current.push_back(current.x() / current.z() + off());
    points_.y_current.push_back(current.y() / current.z() + off());
  }

  Random random_{5};
  double noise_;
  Eigen::Vector3d down_, forward_;
  Triangulation points_;
};

TEST(GroundScale, IsExactOnAnExactPlane) {
  for (const double pitch : {0.0, 10 * kDegree, 35 * kDegree}) {
    DrivingScene scene(pitch);
    scene.addGround(100);
    const Ground ground = scene.measure(scene.prior());
    ASSERT_GT(ground.scale.features, 50) << ground.problem;
    EXPECT_NEAR(ground.scale.length, DrivingScene::kLength, 1e-6);
    EXPECT_TRUE(ground.problem.empty());
    EXPECT_NEAR(ground.normal.dot(scene.prior().down), 1, 1e-9);
  }
}

TEST(GroundScale, FindsTheGroundAmongWallsAndWithAPriorTenDegreesOff) {
  const struct {
    double pitch, prior_error;
    int ground, wall;
  } cases[] = {{2 * kDegree, 2 * kDegree, 80, 100}, {0, 10 * kDegree, 100, 0}};
  for (const auto& [pitch, prior_error, points, wall] : cases) {
    DrivingScene scene(pitch, 0.3);
    scene.addGround(points);
    scene.addWall(wall, 3.5);
    scene.addWall(wall, -4);
    const auto& [scale, problem, normal] = scene.measure(scene.prior(prior_error));
    ASSERT_GT(scale.features, 0) << problem;
    EXPECT_NEAR(scale.length, DrivingScene::kLength, 0.03 * DrivingScene::kLength);
    EXPECT_NEAR(scale.length, DrivingScene::kLength, 3 * scale.relative_sigma * scale.length);
  }
}

TEST(GroundScale, RefusesWhereThereIsNoGround) {
  for (const auto& [ground_points, wall_points] : {std::pair(0, 150), std::pair(5, 0), std::pair(0, 0)}) {
    DrivingScene scene(0, 0.3);
    scene.addGround(ground_points);
    scene.addWall(wall_points, 3);
    const Ground ground = scene.measure(scene.prior());
    EXPECT_EQ(ground.scale.features, 0);
    EXPECT_EQ(ground.problem.find("no ground is seen") == std::string::npos, wall_points > 0) << ground.problem;
    EXPECT_FALSE(ground.problem.empty());
  }
}

TEST(GroundScale, ItsSigmaIsThatOfItsErrors) {
  std::vector<double> normalized;
  for (int k = 0; k < 60; ++k) {
    DrivingScene scene(0, 0.5);
    for (int skip = 0; skip <= k; ++skip) scene.addGround(1);  // other noise each time
    scene.addGround(60);
    const ScaleEstimate scale = scene.measure(scene.prior(0, 1 * kDegree)).scale;
    if (scale.features == 0) continue;
    normalized.push_back(std::abs(scale.length / DrivingScene::kLength - 1) / scale.relative_sigma);
  }
  ASSERT_GT(normalized.size(), 50u);
  EXPECT_LT(percentile(normalized, 90), 2.5);
}

/// The image of a ground with soft stains, `pose` in the frame of the current camera; sky is grey.
cv::Mat drawGround(const Eigen::Isometry3d& pose, const Eigen::Vector3d& down) {
  const Eigen::Matrix3d K_inverse = sceneCamera().K().inverse();
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(128));
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector3d ray = pose.linear() * (K_inverse * Eigen::Vector3d(x, y, 1));
      const double dip = down.dot(ray);
      if (dip < 0.02) continue;
      const Eigen::Vector3d X = pose.translation() + (kCameraHeight - down.dot(pose.translation())) / dip * ray;
      const double a = X.x(), b = X.z();
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(
          128 + 12 * (std::sin(7 * a + 2 * b) + std::sin(3 * a - 5 * b + 1) + std::sin(11 * b + std::sin(4 * a)) +
                      std::sin(13 * a - std::cos(6 * b))));
    }
  }
  return image;
}

TEST(GroundScale, FindsAGroundWithoutCornersInTheImages) {
  const Eigen::Vector3d down = Eigen::Vector3d(0, std::cos(0.15), std::sin(0.15));
  const Eigen::Vector3d forward(0, -std::sin(0.15), std::cos(0.15));
  RelativePose pose;
  pose.R = rotationFromVector({0.002, 0.01, -0.003});
  pose.t = pose.R * forward;
  Eigen::Isometry3d reference = Eigen::Isometry3d::Identity();  // in the current camera's frame
  reference.linear() = pose.R.transpose();
  for (const double length : {0.1, 0.3, 0.8}) {
    reference.translation() = -length * forward;
    const GroundImages images = {drawGround(reference, down), drawGround(Eigen::Isometry3d::Identity(), down)};
    const Ground ground = measureGround({}, pose, sceneCamera(), kLevel, images);
    ASSERT_GT(ground.scale.features, 0) << ground.problem;
    EXPECT_NEAR(ground.scale.length, length, 0.02 * length);
    EXPECT_NEAR(ground.normal.dot(down), 1, 1e-3);
  }
}

GroundImages noiseImages() {
  GroundImages images = {cv::Mat(480, 640, CV_8UC1), cv::Mat(480, 640, CV_8UC1)};
  cv::RNG(1).fill(images.reference, cv::RNG::UNIFORM, 0, 256);
  cv::RNG(2).fill(images.current, cv::RNG::UNIFORM, 0, 256);
  return images;
}

// A sample that the search for a ground moves to where the lens has no inverse is no index into the image.
TEST(GroundScale, LooksNowhereThatTheLensDoesNotReach) {
  CameraIntrinsics intrinsics = sceneCamera().intrinsics();
  intrinsics.distortion_model = "plumb_bob";
  intrinsics.distortion = {-0.9, 0, 0, 0};
  const Camera camera(intrinsics, {640, 480});
  ASSERT_GT(camera.pixelsWithoutInverse(), 0);
  const GroundImages noise = noiseImages();
  for (const Eigen::Vector3d& t : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(1, 0, 0)}) {
    RelativePose pose;
    pose.t = t;
    const Ground ground = measureGround({}, pose, camera, kLevel, noise);
    EXPECT_TRUE(std::isfinite(ground.scale.length) && std::isfinite(ground.scale.relative_sigma));
    EXPECT_TRUE(ground.scale.features > 0 || !ground.problem.empty());
  }
}

TEST(GroundScale, RefusesImagesOfAnythingElse) {
  RelativePose pose;
  pose.t = {0, 0, 1};
  for (const GroundImages& images : {noiseImages(), GroundImages{cv::Mat(480, 640, CV_8UC1, cv::Scalar(90)),
                                                                 cv::Mat(480, 640, CV_8UC1, cv::Scalar(90))}}) {
    const Ground ground = measureGround({}, pose, sceneCamera(), kLevel, images);
    EXPECT_EQ(ground.scale.features, 0);
    EXPECT_NE(ground.problem.find("no ground is seen"), std::string::npos);
  }
}

TEST(GroundScale, MeasuresKitti06) {
  OPEN_OR_SKIP(dataset, "kitti_06");
  const Camera camera(*dataset->intrinsics(), dataset->image(0).size());
  const std::vector<DatasetFrame>& frames = dataset->frames();
  for (const int gap : {1, 3}) {
    std::vector<double> errors, normalized;
    const auto measure = [&](int i, const Frame&, const Frame&, const MatchResult& result, const auto& points) {
      if (result.status != Status::kOk) return;
      const GroundImages images = {dataset->image(i), dataset->image(i + gap)};
      const ScaleEstimate scale = measureGround(points, result.robust.judgement.pose, camera, kLevel, images).scale;
      if (scale.features == 0) return;
      const double truth = (frames[i].pose->inverse() * *frames[i + gap].pose).translation().norm();
      errors.push_back(std::abs(scale.length / truth - 1));
      normalized.push_back(errors.back() / scale.relative_sigma);
    };
    forEachPair(
        camera, static_cast<int>(frames.size()), gap, 0, [&](int i) { return dataset->image(i); }, measure);
    ASSERT_GT(errors.size(), (frames.size() - gap) / 2);
    EXPECT_LT(median(errors), 0.02) << gap;
    EXPECT_LT(percentile(errors, 90), 0.05) << gap;
    EXPECT_LT(median(normalized), 1.2) << gap;
  }
}

}  // namespace
}  // namespace gms_ransac
