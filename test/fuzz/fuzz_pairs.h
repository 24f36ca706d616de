// Two images' keypoints and the matches between them, as a fuzzed input describes them: a scene with a motion, and
// keypoints and matches that break every rule.
#pragma once

#include <Eigen/Geometry>

#include "fuzz_input.h"
#include "gms_ransac/match_filter.h"
#include "survivors.h"

namespace gms_ransac {

struct FuzzedPair {
  Frame reference, current;
  std::vector<Match> matches;
  Camera camera;

  /// The matches as an estimator gets them, all with that score.
  PointPairs columns(int score = 0) const {
    MotionStatistics statistics;
    statistics.accepted.assign(matches.size(), 1);
    statistics.score.assign(matches.size(), score);
    statistics.relative_score.assign(matches.size(), static_cast<float>(score));
    MatchResult all;
    all.raw = matches;
    SurvivorSelector(false, false).select(reference.features, current.features, statistics, Camera(), all);
    return all.pairs;
  }
};

/// A number of matches: mostly few, seldom very many.
inline int fuzzedCount(FuzzInput& input, int most) {
  const uint8_t kind = input.byte();
  if (kind < 160) return input.between(0, 255);
  if (kind < 252) return std::min(most, input.between(0, 1500));
  return input.between(0, most);
}

/// How the points of the current image come from those of the reference.
enum class FuzzedScene { kMotion, kPlane, kTurn, kStill, kNoise, kLine, kOnePoint, kCount };

inline FuzzedPair fuzzedPair(FuzzInput& input, int most_matches) {
  FuzzedPair pair;
  const cv::Size size(input.between(1, 2000), input.between(1, 2000));
  const bool odd_size = input.byte() > 248;
  pair.reference.features.image_size = odd_size ? cv::Size(0, 0) : size;
  pair.current.features.image_size =
      input.byte() > 248 ? cv::Size(input.between(0, 70000), input.between(0, 70000)) : size;
  const double f = input.within(0.2, 3) * size.width;
  if (input.byte() < 200) {
    CameraIntrinsics k{f, f, size.width / 2.0, size.height / 2.0, "", {}};
    if (input.byte() > 224)
      k = {input.number(1e-3, 1e6), input.number(1e-3, 1e6), input.number(-1e6, 1e6), input.number(-1e6, 1e6), "", {}};
    try {
      k.validate();
      pair.camera = Camera(k, size);
    } catch (const std::invalid_argument&) {
      // not calibrated
    }
  }
  const auto scene = static_cast<FuzzedScene>(input.between(0, static_cast<int>(FuzzedScene::kCount) - 1));
  const int n = fuzzedCount(input, most_matches);
  const double outliers = input.within(0, 1), noise = input.byte() < 200 ? input.within(0, 2) : 0;
  const bool on_grid = input.byte() > 200;  // many points in one place
  const Eigen::Vector3d t(input.within(-1, 1), input.within(-1, 1), input.within(-1, 1));
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(input.within(-0.5, 0.5), Eigen::Vector3d::UnitX()) *
                             Eigen::AngleAxisd(input.within(-0.5, 0.5), Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(input.within(-3.2, 3.2), Eigen::Vector3d::UnitZ()))
                                .toRotationMatrix();
  Random random = input.random();
  const auto uniform = [&random](double low, double high) { return low + (high - low) * random.uniform(); };
  const Eigen::Vector2d place(uniform(0, size.width), uniform(0, size.height));
  for (int i = 0; i < n; ++i) {
    Eigen::Vector2d from(uniform(0, size.width), uniform(0, size.height));
    if (on_grid) from = (from / 64).array().floor() * 64;
    if (scene == FuzzedScene::kLine) from = place + uniform(-1, 1) * t.head<2>() * size.width;
    if (scene == FuzzedScene::kOnePoint) from = place;
    const double depth = scene == FuzzedScene::kPlane ? 5 + from.x() / size.width : uniform(1, 10);
    const Eigen::Vector3d ray((from.x() - size.width / 2.0) / f, (from.y() - size.height / 2.0) / f, 1);
    const bool moves = scene == FuzzedScene::kMotion || scene == FuzzedScene::kPlane || scene == FuzzedScene::kLine;
    Eigen::Vector3d seen = depth * ray;
    if (scene != FuzzedScene::kStill) seen = R * seen;
    if (moves) seen += t;
    Eigen::Vector2d to = f * seen.hnormalized() + Eigen::Vector2d(size.width / 2.0, size.height / 2.0);
    if (scene == FuzzedScene::kNoise || uniform(0, 1) < outliers)
      to = {uniform(0, size.width), uniform(0, size.height)};
    if (scene == FuzzedScene::kOnePoint) to = place;
    to += noise * Eigen::Vector2d(uniform(-1, 1), uniform(-1, 1));
    const auto keypoint = [&](const Eigen::Vector2d& p) {
      cv::KeyPoint k;
      k.pt = {static_cast<float>(p.x()), static_cast<float>(p.y())};
      k.octave = random.below(8);
      k.angle = static_cast<float>(uniform(0, 360));
      k.size = 31;
      k.response = static_cast<float>(uniform(0, 1));
      return k;
    };
    pair.reference.features.keypoints.push_back(keypoint(from));
    pair.current.features.keypoints.push_back(keypoint(to));
    const auto distance = static_cast<uint16_t>(random.below(120));
    pair.matches.push_back({i, i, distance, static_cast<uint16_t>(std::min(257, distance + random.below(60)))});
  }
  // Single odd keypoints and matches, given one by one.
  for (int k = input.between(0, 12); k > 0 && n > 0; --k) {
    auto& features = input.flag() ? pair.reference.features : pair.current.features;
    cv::KeyPoint& keypoint = features.keypoints[static_cast<size_t>(input.between(0, n - 1))];
    const int kind = input.between(0, 4);
    if (kind == 0) keypoint.pt.x = input.number32(-10, 3000);
    if (kind == 1) keypoint.pt.y = input.number32(-10, 3000);
    if (kind == 2) keypoint.octave = input.flag() ? input.between(0, 255) : input.raw<int32_t>();
    if (kind == 3) keypoint.angle = input.number32(-1, 360);
    if (kind == 4) {
      pair.matches[static_cast<size_t>(input.between(0, n - 1))].current = input.between(0, n - 1);
    }
  }
  return pair;
}

}  // namespace gms_ransac
