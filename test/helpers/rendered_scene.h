// The rendered scenes as tests use them: each painted once in a program, and each frame rendered once.
#pragma once

#include <map>
#include <string>
#include <tuple>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "gms_ransac/relative_pose.h"
#include "scenes/scene.h"

namespace gms_ransac {

inline const Scene& renderedScene(const std::string& name = "room", uint64_t seed = 0) {
  static std::map<std::tuple<std::string, uint64_t>, Scene> scenes;
  SceneOptions options;
  options.scene = name;
  options.seed = seed;
  return scenes.try_emplace({name, seed}, options).first->second;
}

inline const RenderedFrame& renderedFrame(int index, const std::string& name = "room", uint64_t seed = 0) {
  static std::map<std::tuple<std::string, uint64_t, int>, RenderedFrame> frames;
  const auto [place, is_new] = frames.try_emplace({name, seed, index});
  if (is_new) place->second = renderedScene(name, seed).render(index);
  return place->second;
}

/// True pose of frame `current` in frame `reference`; covariance zero.
inline RelativePose trueRelativePose(const Scene& scene, int reference, int current) {
  const Eigen::Isometry3d pose = scene.pose(reference).inverse() * scene.pose(current);
  RelativePose result;
  result.R = pose.linear();
  result.t = pose.translation();
  return result;
}

/// Squared error over its covariance, over six: 1 where the covariance is true.
inline double nees(const RelativePose& pose, const RelativePose& truth) {
  Eigen::Matrix<double, 6, 1> error;
  const Eigen::AngleAxisd turn(truth.R * pose.R.transpose());
  error << truth.t - pose.t, turn.angle() * turn.axis();
  return error.dot(pose.covariance.llt().solve(error)) / 6;
}

inline Camera cameraOf(const Scene& scene) { return Camera(scene.intrinsics(), scene.options().size); }

}  // namespace gms_ransac
