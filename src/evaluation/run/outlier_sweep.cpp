#include "run/outlier_sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <Eigen/Geometry>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/motion_statistics.h"
#include "methods/method.h"
#include "run/metrics.h"
#include "scenes/synthetic_pair.h"
#include "validation.h"

namespace gms_ransac {

namespace {

constexpr int kFrameGap = 3;  ///< of the room: about 0.25 m of motion at 3 m distance
constexpr double kRatios[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};

std::vector<std::string> methodNames(const OutlierSweepOptions& options) {
  if (!options.methods.empty()) return options.methods;
  std::vector<std::string> names;
  for (const MethodEntry& method : methods()) names.push_back(method.name);
  return names;
}

PointPairs toPointPairs(const SyntheticPair& pair, MotionStatisticsFilter& filter, MotionStatistics& statistics) {
  filter.compute(pair.reference, pair.current, pair.matches, statistics);
  PointPairs pairs;
  pairs.resize(static_cast<int>(pair.matches.size()));
  pairs.image_reference = pair.reference.image_size;
  pairs.image_current = pair.current.image_size;
  for (size_t i = 0; i < pair.matches.size(); ++i) {
    const cv::Point2f a = pair.reference.keypoints[static_cast<size_t>(pair.matches[i].reference)].pt;
    const cv::Point2f b = pair.current.keypoints[static_cast<size_t>(pair.matches[i].current)].pt;
    pairs.x_reference[i] = a.x;
    pairs.y_reference[i] = a.y;
    pairs.x_current[i] = b.x;
    pairs.y_current[i] = b.y;
    pairs.octave_reference[i] = pairs.octave_current[i] = 0;
    pairs.score[i] = statistics.score[i];
    pairs.relative_score[i] = statistics.relative_score[i];
    pairs.distance[i] = pair.matches[i].distance;
    pairs.second_distance[i] = pair.matches[i].second_distance;
  }
  return pairs;
}

bool succeeded(const RobustResult& result, const RelativePose& truth) {
  if (!result.pose_found) return false;
  const double rotation = kDegrees * Eigen::AngleAxisd(truth.R.transpose() * result.pose.R).angle();
  const double direction = kDegrees * std::atan2(result.pose.t.cross(truth.t).norm(), result.pose.t.dot(truth.t));
  return rotation < kSweepRotationLimit && direction < kSweepDirectionLimit;
}

nlohmann::json trialRecord(const std::string& method, double ratio, const RobustResult& result,
                           const SyntheticPair& pair, const RelativePose& truth, double seconds) {
  int correct = 0, kept_correct = 0;
  for (size_t i = 0; i < pair.correct.size(); ++i) {
    correct += pair.correct[i];
    kept_correct += pair.correct[i] && result.inlier[i];
  }
  return {{"method", method},
          {"order", findMethod(method).ordered ? "confidence" : "uniform"},
          {"outlier_ratio", ratio},
          {"success", succeeded(result, truth)},
          {"hypotheses", result.effort.hypotheses},
          {"models_scored", result.effort.models_scored},
          {"point_evaluations", result.effort.point_evaluations},
          {"milliseconds", 1e3 * seconds},
          {"precision", static_cast<double>(kept_correct) / std::max(1, result.inlier_count)},
          {"recall", static_cast<double>(kept_correct) / std::max(1, correct)}};
}

}  // namespace

void OutlierSweepOptions::validate() const {
  for (const std::string& method : methods) findMethod(method);
  robust.validate();
  requireInRange("matches", matches, 10, 100000);
  requireInRange("noise", noise, 0.0, 10.0);
  requireInRange("repeat", repeat, 1, 100000);
}

int sweepLength(const OutlierSweepOptions& options) {
  return static_cast<int>(methodNames(options).size() * std::size(kRatios)) * options.repeat;
}

void sweepOutliers(const OutlierSweepOptions& options, const std::function<void(const nlohmann::json&)>& receive) {
  options.validate();
  const Scene scene{SceneOptions()};
  const Camera camera(scene.intrinsics(), scene.options().size);
  const std::vector<std::string> names = methodNames(options);
  MotionStatisticsFilter filter;
  MotionStatistics statistics;
  RobustResult result;
  for (const double ratio : kRatios) {
    for (int trial = 0; trial < options.repeat; ++trial) {
      SyntheticPairOptions pair_options;
      pair_options.matches = options.matches;
      pair_options.outlier_ratio = ratio;
      pair_options.noise = options.noise;
      pair_options.seed = options.robust.seed + static_cast<uint64_t>(trial);
      const SyntheticPair pair = makeSyntheticPair(scene, trial, trial + kFrameGap, pair_options);
      const RelativePose truth = trueRelativePose(scene, trial, trial + kFrameGap);
      const PointPairs pairs = toPointPairs(pair, filter, statistics);
      MatchFilterOptions method_options;
      method_options.robust = options.robust;
      method_options.robust.seed = pair_options.seed;
      for (const std::string& name : names) {
        method_options.method = name;
        const auto method = makeMethod(method_options);
        const auto start = std::chrono::steady_clock::now();
        method->estimate(pairs, camera, result);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        receive(trialRecord(name, ratio, result, pair, truth, seconds));
      }
    }
  }
}

}  // namespace gms_ransac
