// Additions to the drawn two-view scenes for tests: exact samples for solvers, and the error of an answer.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"
#include "methods/method.h"
#include "scenes/two_view_scene.h"
#include "support/random.h"

namespace gms_ransac {

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

/// The names of all methods.
inline std::vector<std::string> methodNames() {
  std::vector<std::string> names;
  for (const MethodEntry& method : methods()) names.push_back(method.name);
  return names;
}

/// The method of that name with these options of its robust stage.
inline std::unique_ptr<Method> makeEstimator(const std::string& method, const RobustOptions& robust) {
  MatchFilterOptions options;
  options.method = method;
  options.robust = robust;
  return makeMethod(options);
}

/// The answer of a method to a scene.
inline RobustResult estimated(Method& method, const TwoViewScene& scene) {
  RobustResult result;
  method.estimate(scene.pairs, scene.camera, result);
  return result;
}

inline RobustResult estimated(const std::string& method, const RobustOptions& options, const TwoViewScene& scene) {
  return estimated(*makeEstimator(method, options), scene);
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
  return {rotationError(result.judgement.pose.R, R.transpose()),
          directionError(result.judgement.pose.t, -R.transpose() * t)};
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
