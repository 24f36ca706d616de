// Two-view correspondences with exact truth, for tests of estimators.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_filter.h"
#include "gms_ransac/robust_estimator.h"
#include "random.h"

namespace gms_ransac {

enum class SceneShape { kVolume, kPlane };

struct TwoViewSceneOptions {
  int matches = 1000;
  double outlier_ratio = 0.3;
  double noise_px = 0.3;  ///< standard deviation in each coordinate of each image
  SceneShape shape = SceneShape::kVolume;
  Eigen::Vector3d translation{0.4, -0.1, 0.25};  ///< X_current = R X_reference + translation, metres
  Eigen::Vector3d rotation{0.02, -0.06, 0.03};   ///< rotation vector of that R, radians
  Eigen::Vector3d plane_normal{0.3, -0.2, 1};    ///< in the reference frame; tilted: its homography is no similarity
  double plane_distance = 8;                     ///< metres along that normal, whatever its length
  bool informative = true;  ///< score and distance tell inliers from outliers, with overlap; otherwise they are noise
  uint64_t seed = 1;
};

struct TwoViewScene {
  Camera camera;
  PointPairs pairs;
  std::vector<uint8_t> correct;  ///< true label of each match
  Eigen::Matrix3d R;             ///< X_current = R X_reference + t
  Eigen::Vector3d t;
};

inline double gaussian(Random& random) {
  const double u = random.uniform(), v = random.uniform();
  return std::sqrt(-2 * std::log(1 - u)) * std::cos(2 * 3.14159265358979323846 * v);
}

/// Points 4 to 12 m in front of a 640 x 480 camera with f = 500 px; outliers are uniform in both images.
inline TwoViewScene makeTwoViewScene(const TwoViewSceneOptions& options) {
  TwoViewScene pair;
  CameraIntrinsics intrinsics;
  intrinsics.fx = intrinsics.fy = 500;
  intrinsics.cx = 320;
  intrinsics.cy = 240;
  pair.camera = Camera(intrinsics, {640, 480});
  const Eigen::Matrix3d K = pair.camera.K();
  const double angle = options.rotation.norm();
  pair.R = angle > 0 ? Eigen::AngleAxisd(angle, options.rotation / angle).toRotationMatrix()
                     : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  pair.t = options.translation;

  Random random(options.seed);
  PointPairs& columns = pair.pairs;
  columns.resize(options.matches);
  columns.image_reference = columns.image_current = {640, 480};
  pair.correct.resize(static_cast<size_t>(options.matches));
  for (size_t i = 0; i < pair.correct.size(); ++i) {
    const bool outlier = random.uniform() < options.outlier_ratio;
    const Eigen::Vector2d reference(640 * random.uniform(), 480 * random.uniform());
    const Eigen::Vector3d ray = K.inverse() * reference.homogeneous();
    const double depth = options.shape == SceneShape::kPlane ? options.plane_distance / options.plane_normal.dot(ray)
                                                             : 4 + 8 * random.uniform();
    Eigen::Vector2d current = (K * (pair.R * (depth * ray) + pair.t)).hnormalized();
    if (outlier) current = {640 * random.uniform(), 480 * random.uniform()};
    columns.x_reference[i] = static_cast<float>(reference.x() + options.noise_px * gaussian(random));
    columns.y_reference[i] = static_cast<float>(reference.y() + options.noise_px * gaussian(random));
    columns.x_current[i] = static_cast<float>(current.x() + options.noise_px * gaussian(random));
    columns.y_current[i] = static_cast<float>(current.y() + options.noise_px * gaussian(random));
    columns.octave_reference[i] = columns.octave_current[i] = 0;
    const double quality = (options.informative && !outlier ? 1 : 0) + gaussian(random);
    columns.score[i] = std::max(0, static_cast<int>(30 + 10 * quality));
    columns.support[i] = static_cast<float>(columns.score[i]) / 15;
    columns.distance[i] = static_cast<uint16_t>(std::min(256., std::max(0., 60 - 15 * quality)));
    columns.second_distance[i] = static_cast<uint16_t>(columns.distance[i] + random.below(20));
    pair.correct[i] = !outlier;
  }
  return pair;
}

/// The method of that name with these options of its robust stage.
inline std::unique_ptr<Method> makeEstimator(const std::string& method, const RobustOptions& robust) {
  MatchFilterOptions options;
  options.method = method;
  options.robust = robust;
  return makeMethod(options);
}

/// Degrees between two rotations.
inline double rotationError(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a.transpose() * b).angle() * 180 / 3.14159265358979323846;
}

/// Degrees between two directions.
inline double directionError(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / 3.14159265358979323846;
}

}  // namespace gms_ransac
