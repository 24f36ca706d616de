// Two views of known points, with exact truth: noisy matches for tests of estimators, exact samples for those of
// solvers.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

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
  double nearest = 4, farthest = 12;             ///< depths of the volume, metres
  bool mostly_near = false;                      ///< these are uniform in the inverse of the depth, not in the depth
  double image_share = 1;  ///< of each side of the reference image that shows points, about its middle
  bool octaves = false;  ///< keypoints of all eight levels of a pyramid, the coarse less accurate; otherwise of level 0
  bool informative = true;  ///< score and distance tell inliers from outliers, with overlap; otherwise they are noise
  uint64_t seed = 1;
};

struct TwoViewScene {
  Camera camera;
  PointPairs pairs;
  std::vector<uint8_t> correct;         ///< true label of each match
  std::vector<Eigen::Vector3d> points;  ///< what the reference sees at each match, in its frame
  Eigen::Matrix3d R;                    ///< X_current = R X_reference + t
  Eigen::Vector3d t;
  Eigen::Vector3d plane;  ///< its points X have plane . X = 1, in the reference frame; zero for a volume
};

/// 640 x 480 pixels, f = 500 px.
inline Camera sceneCamera() {
  CameraIntrinsics intrinsics;
  intrinsics.fx = intrinsics.fy = 500;
  intrinsics.cx = 320;
  intrinsics.cy = 240;
  return Camera(intrinsics, {640, 480});
}

inline double gaussian(Random& random) {
  const double u = random.uniform(), v = random.uniform();
  return std::sqrt(-2 * std::log(1 - u)) * std::cos(2 * 3.14159265358979323846 * v);
}

inline Eigen::Matrix3d rotationOf(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

/// A depth of the volume, `share` of the way from the nearest to the farthest.
inline double depthIn(const TwoViewSceneOptions& options, double share) {
  if (!options.mostly_near) return options.nearest + share * (options.farthest - options.nearest);
  return 1 / (1 / options.nearest + share * (1 / options.farthest - 1 / options.nearest));
}

/// Points that both images of a sceneCamera() show; a wrong match ends anywhere in the current image.
inline TwoViewScene makeTwoViewScene(const TwoViewSceneOptions& options) {
  TwoViewScene scene;
  scene.camera = sceneCamera();
  const Eigen::Matrix3d K = scene.camera.K(), K_inverse = K.inverse();
  const bool planar = options.shape == SceneShape::kPlane;
  scene.R = rotationOf(options.rotation);
  scene.t = options.translation;
  scene.plane = planar ? Eigen::Vector3d(options.plane_normal / options.plane_distance) : Eigen::Vector3d(0, 0, 0);

  Random random(options.seed);
  PointPairs& columns = scene.pairs;
  columns.resize(options.matches);
  columns.image_reference = columns.image_current = {640, 480};
  scene.correct.resize(static_cast<size_t>(options.matches));
  scene.points.resize(scene.correct.size());
  const auto about = [&](double length) { return length * (0.5 + options.image_share * (random.uniform() - 0.5)); };
  for (size_t i = 0; i < scene.correct.size();) {
    const bool outlier = random.uniform() < options.outlier_ratio;
    const Eigen::Vector2d reference(about(640), about(480));
    const Eigen::Vector3d ray = K_inverse * reference.homogeneous();
    const double depth = planar ? 1 / scene.plane.dot(ray) : depthIn(options, random.uniform());
    const Eigen::Vector3d moved = scene.R * (depth * ray) + scene.t;
    Eigen::Vector2d current = (K * moved).hnormalized();
    const bool seen =
        depth > 0 && moved.z() > 0 && current.x() >= 0 && current.x() < 640 && current.y() >= 0 && current.y() < 480;
    if (!seen) continue;
    if (outlier) current = {640 * random.uniform(), 480 * random.uniform()};
    const int octave = options.octaves ? static_cast<int>(8 * random.uniform() * random.uniform()) : 0;
    const double sigma = options.noise_px * std::pow(1.2, 0.5 * octave);
    columns.x_reference[i] = static_cast<float>(reference.x() + sigma * gaussian(random));
    columns.y_reference[i] = static_cast<float>(reference.y() + sigma * gaussian(random));
    columns.x_current[i] = static_cast<float>(current.x() + sigma * gaussian(random));
    columns.y_current[i] = static_cast<float>(current.y() + sigma * gaussian(random));
    columns.octave_reference[i] = columns.octave_current[i] = static_cast<uint8_t>(octave);
    const double quality = (options.informative && !outlier ? 1 : 0) + gaussian(random);
    columns.score[i] = std::max(0, static_cast<int>(30 + 10 * quality));
    columns.relative_score[i] = static_cast<float>(columns.score[i]) / 15;
    columns.distance[i] = static_cast<uint16_t>(std::min(256., std::max(0., 60 - 15 * quality)));
    columns.second_distance[i] = static_cast<uint16_t>(columns.distance[i] + random.below(20));
    scene.points[i] = depth * ray;
    scene.correct[i] = !outlier;
    ++i;
  }
  return scene;
}

/// Two views of random points by a random motion, X_current = R X_reference + t, in normalised coordinates and without
/// any error: samples for minimal solvers.
struct ExactViews {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  Random random;

  explicit ExactViews(uint64_t seed, double baseline = 1, double angle = 0.5) : random(seed) {
    R = Eigen::AngleAxisd(angle * random.uniform(), inCube().normalized()).toRotationMatrix();
    t = baseline * inCube().normalized();
  }
  Eigen::Vector3d point() { return {uniform(-3, 3), uniform(-3, 3), uniform(4, 9)}; }
  Eigen::Vector3d pointOnPlane() {
    const double x = uniform(-3, 3), y = uniform(-3, 3);
    return {x, y, 6 + 0.2 * x - 0.3 * y};
  }
  void project(const Eigen::Vector3d& X, double (&x1)[2], double (&x2)[2]) const {
    const Eigen::Vector3d Y = R * X + t;
    x1[0] = X.x() / X.z();
    x1[1] = X.y() / X.z();
    x2[0] = Y.x() / Y.z();
    x2[1] = Y.y() / Y.z();
  }

 private:
  double uniform(double low, double high) { return low + (high - low) * random.uniform(); }
  Eigen::Vector3d inCube() {
    const double x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
    return {x, y, z};
  }
};

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

/// Errors of a pose against the motion of a scene, degrees.
struct PoseErrors {
  double rotation, direction;
};

inline PoseErrors poseErrors(const RobustResult& result, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  return {rotationError(result.pose.R, R.transpose()), directionError(result.pose.t, -R.transpose() * t)};
}

inline PoseErrors poseErrors(const RobustResult& result, const TwoViewScene& scene) {
  return poseErrors(result, scene.R, scene.t);
}

/// Two motions explain the views of a plane equally well: the errors against the nearer one.
inline PoseErrors planePoseErrors(const RobustResult& result, const TwoViewScene& scene) {
  cv::Mat H;
  cv::eigen2cv(Eigen::Matrix3d(scene.R + scene.t * scene.plane.transpose()), H);
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(H, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  PoseErrors best = {180, 180};
  for (size_t i = 0; i < rotations.size(); ++i) {
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
    cv::cv2eigen(rotations[i], R);
    cv::cv2eigen(translations[i], t);
    const PoseErrors errors = poseErrors(result, R, t);
    if (errors.direction < best.direction) best = errors;
  }
  return best;
}

/// How many correct matches are inliers.
inline int correctKept(const RobustResult& result, const TwoViewScene& scene) {
  int kept = 0;
  for (size_t i = 0; i < scene.correct.size(); ++i) kept += result.inlier[i] && scene.correct[i];
  return kept;
}

}  // namespace gms_ransac
