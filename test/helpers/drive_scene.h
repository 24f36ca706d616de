// A drive past known points, image by image, with exact truth: sequences for tests of what pairs add up to.
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "two_view/pose_model.h"
#include "two_view_scene.h"

namespace gms_ransac {

/// A step of these metres and that rotation vector, radians.
inline Eigen::Isometry3d makeStep(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation) {
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  step.linear() = rotationFromVector(rotation);
  step.translation() = translation;
  return step;
}

/// A camera that moves by the same step from image to image, among points 4 to 20 m away that it sees until they leave
/// the view.
class Drive {
 public:
  /// `step`: pose of each camera in that of the one before. `keypoints_stay`: a keypoint is as far off as reference as
  /// it was as current; else its noise is drawn anew.
  Drive(uint64_t seed, const Eigen::Isometry3d& step, bool keypoints_stay)
      : random_(seed), step_(step), keypoints_stay_(keypoints_stay) {
    look();
  }

  const Eigen::Isometry3d& pose() const { return pose_; }

  /// On to the next image: its matches with the one before.
  PointPairs advance() {
    std::vector<Seen> before = seen_;
    pose_ = pose_ * step_;
    seen_.clear();
    PointPairs pairs;
    pairs.resize(static_cast<int>(before.size()));
    pairs.image_reference = pairs.image_current = camera_.imageSize();
    int n = 0;
    for (const Seen& old : before) {
      Eigen::Vector2d pixel;
      if (!project(old.point, pixel)) continue;
      const Eigen::Vector2d from = keypoints_stay_ ? old.keypoint : Eigen::Vector2d(old.pixel + noise());
      const Seen now = {old.point, pixel, pixel + noise()};
      const bool wrong = random_.uniform() < kOutliers;
      const Eigen::Vector2d to = wrong ? anyPixel() : now.keypoint;
      setMatch(pairs, n++, from, to);
      seen_.push_back(now);
    }
    pairs.resize(n);
    look();
    return pairs;
  }

 private:
  static constexpr size_t kPointsInView = 300;
  static constexpr double kNoise = 0.4, kOutliers = 0.1;  ///< pixels; share of the matches

  struct Seen {
    Eigen::Vector3d point;            ///< in the first camera's frame
    Eigen::Vector2d pixel, keypoint;  ///< exact and with noise
  };

  static void setMatch(PointPairs& pairs, int n, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const auto i = static_cast<size_t>(n);
    pairs.x_reference[i] = static_cast<float>(from.x());
    pairs.y_reference[i] = static_cast<float>(from.y());
    pairs.x_current[i] = static_cast<float>(to.x());
    pairs.y_current[i] = static_cast<float>(to.y());
    pairs.distance[i] = 30;
    pairs.second_distance[i] = 60;
  }
  Eigen::Vector2d anyPixel() { return {640 * random_.uniform(), 480 * random_.uniform()}; }
  Eigen::Vector2d noise() {
    const double x = gaussian(random_), y = gaussian(random_);
    return kNoise * Eigen::Vector2d(x, y);
  }
  bool project(const Eigen::Vector3d& point, Eigen::Vector2d& pixel) const {
    const Eigen::Vector3d here = pose_.inverse() * point;
    if (here.z() < 1) return false;
    pixel = (camera_.K() * here).hnormalized();
    return pixel.x() > 0 && pixel.x() < 640 && pixel.y() > 0 && pixel.y() < 480;
  }
  /// Fills up the points in view.
  void look() {
    while (seen_.size() < kPointsInView) {
      const Eigen::Vector2d pixel = anyPixel();
      const double depth = 4 + 16 * random_.uniform();
      const Eigen::Vector3d point = pose_ * (depth * (camera_.K().inverse() * pixel.homogeneous()));
      seen_.push_back({point, pixel, pixel + noise()});
    }
  }

  Random random_;
  Eigen::Isometry3d step_, pose_ = Eigen::Isometry3d::Identity();
  bool keypoints_stay_;
  Camera camera_ = sceneCamera();
  std::vector<Seen> seen_;
};

}  // namespace gms_ransac
