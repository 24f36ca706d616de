// `evaluate sweep`: how each method's estimator holds out against outliers, on correspondences of the rendered scene
// with exact labels. There is no filter stage, so that the estimator meets the given ratio; the motion statistics give
// the score by which methods order. Methods that differ only in the filter have equal results.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"
#include "run/evaluate_commands.h"
#include "run/pair_truth.h"
#include "scenes/scene.h"
#include "survivors.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

constexpr int kFrameGap = 3;  ///< of the room: about 0.25 m of motion at 3 m distance
constexpr double kRatios[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
/// A trial is a success within these errors, degrees: several times what a method reaches without outliers in the least
/// favourable of its repetitions.
constexpr double kRotationLimit = 1, kDirectionLimit = 5;

// Distances of correct and wrong nearest neighbours, bits: mean and deviation measured with cv::ORB and 2000 features
// on neighbouring frames of the room.
constexpr double kCorrectDistance = 27, kCorrectSpread = 14;
constexpr double kWrongDistance = 67, kWrongSpread = 8;
constexpr int kMatches = 1000;
constexpr double kNoise = 0.5;  ///< standard deviation of the current point of a correct match, pixels

/// Features without descriptors; match i joins reference keypoint i with current keypoint i. Hamming distances are
/// drawn as ORB's are on rendered frames, so that correct and wrong ones overlap.
struct SyntheticPair {
  Features reference, current;
  std::vector<Match> matches;
  std::vector<uint8_t> correct;  ///< one for each match
};

uint16_t drawDistance(cv::RNG& rng, double mean, double spread) {
  return cv::saturate_cast<uint16_t>(std::clamp(mean + rng.gaussian(spread), 0.0, 256.0));
}

/// Correspondences of two frames of the scene, of which `outlier_ratio` end anywhere in the image.
SyntheticPair makeSyntheticPair(const Scene& scene, int reference, int current, double outlier_ratio, uint64_t seed) {
  SyntheticPair pair;
  const cv::Size size = scene.options().size;
  pair.reference.image_size = pair.current.image_size = size;
  pair.correct.assign(kMatches, 1);
  std::fill_n(pair.correct.begin(), cvRound(outlier_ratio * kMatches), 0);
  cv::RNG rng(seed + 1);
  const auto random_pixel = [&] {
    const double x = rng.uniform(0.0, size.width - 1.0), y = rng.uniform(0.0, size.height - 1.0);
    return cv::Point2d(x, y);
  };
  for (int i = kMatches - 1; i > 0; --i) std::swap(pair.correct[i], pair.correct[rng.uniform(0, i + 1)]);

  for (int i = 0; i < kMatches; ++i) {
    cv::Point2d from = random_pixel(), to = random_pixel();
    if (pair.correct[i]) {
      while (!scene.correspondence(reference, from, current, to)) from = random_pixel();
      to.x = std::clamp(to.x + rng.gaussian(kNoise), 0.0, size.width - 1.0);
      to.y = std::clamp(to.y + rng.gaussian(kNoise), 0.0, size.height - 1.0);
    }
    pair.reference.keypoints.emplace_back(cv::Point2f(from), 31.f);
    pair.current.keypoints.emplace_back(cv::Point2f(to), 31.f);
    const uint16_t distance = pair.correct[i] ? drawDistance(rng, kCorrectDistance, kCorrectSpread)
                                              : drawDistance(rng, kWrongDistance, kWrongSpread);
    const uint16_t second = std::max(distance, drawDistance(rng, kWrongDistance, kWrongSpread));
    pair.matches.push_back({i, i, distance, second});
  }
  return pair;
}

nlohmann::json trialRecord(const std::string& method, double ratio, const RobustResult& result,
                           const SyntheticPair& pair, const Eigen::Isometry3d& truth, double seconds) {
  int correct = 0, kept_correct = 0;
  for (size_t i = 0; i < pair.correct.size(); ++i) {
    correct += pair.correct[i];
    kept_correct += pair.correct[i] && result.inlier[i];
  }
  const PoseError error = result.pose_found ? poseError(truth, result.pose.R, result.pose.t) : PoseError();
  return {{"method", method},
          {"order", findMethod(method).ordered ? "confidence" : "uniform"},
          {"outlier_ratio", ratio},
          {"success", error.rotation < kRotationLimit && error.direction < kDirectionLimit},
          {"hypotheses", result.effort.hypotheses},
          {"models_scored", result.effort.models_scored},
          {"point_evaluations", result.effort.point_evaluations},
          {"milliseconds", 1e3 * seconds},
          {"precision", static_cast<double>(kept_correct) / std::max(1, result.inlier_count)},
          {"recall", static_cast<double>(kept_correct) / std::max(1, correct)}};
}

}  // namespace

int evaluateSweep(const Arguments& arguments) {
  int repeat = 50;
  PipelineArguments pipeline;
  std::string out;
  po::options_description options;
  auto add = options.add_options();
  add("repeat", withDefault(repeat), "trials for each method and outlier ratio");
  add("out,o", po::value(&out), "file for the table, CSV, with the plot beside it; standard output without");
  add("no-plots", "only CSV");
  pipeline.addTo(options, arguments);
  std::ostringstream usage;
  usage << "evaluate sweep [options]\n\nSuccess rate and effort of each method's estimator at outlier ratios of 0.1 to "
           "0.9, on correspondences of the\nrendered scene. Success: rotation within "
        << kRotationLimit << " degree and direction within " << kDirectionLimit
        << " degrees. Without --method all;\noptions of extraction, matching and filter have no effect.";
  const auto given = parseCommandLine(arguments, usage.str(), options);
  if (!given) return 0;
  const std::vector<std::string> names = pipeline.methodNames(allMethodNames());
  MatchFilterOptions method_options = pipeline.options(pipeline.base.method);
  if (method_options.robust.model == ModelType::kHomography) {
    throw std::invalid_argument("--model is 'homography'; the scene is no plane: it must be essential or fundamental");
  }
  requireAtLeastOne({{"--repeat", repeat}});
  if (!out.empty() && !std::ofstream(out)) throw std::invalid_argument("cannot write " + out);
  std::vector<std::string> report = {"sweep"};
  if (!out.empty()) report.insert(report.end(), {"--out", out});
  if (given->count("no-plots")) report.push_back("--no-plots");
  Reporter reporter(report);
  {
    Progress progress("trials", static_cast<int>(names.size() * std::size(kRatios)) * repeat);
    const Scene scene{SceneOptions()};
    const Camera camera(scene.intrinsics(), scene.options().size);
    MotionStatisticsFilter filter;
    MotionStatistics statistics;
    Survivors all;
    RobustResult result;
    const uint64_t first_seed = method_options.robust.seed;
    for (const double ratio : kRatios) {
      for (int trial = 0; trial < repeat; ++trial) {
        const uint64_t seed = method_options.robust.seed = first_seed + static_cast<uint64_t>(trial);
        const SyntheticPair pair = makeSyntheticPair(scene, trial, trial + kFrameGap, ratio, seed);
        const Eigen::Isometry3d truth = scene.pose(trial).inverse() * scene.pose(trial + kFrameGap);
        filter.compute(pair.reference, pair.current, pair.matches, statistics);
        std::fill(statistics.accepted.begin(), statistics.accepted.end(), 1);
        SurvivorSelector(false, false).select(pair.reference, pair.current, pair.matches, statistics, camera, all);
        for (const std::string& name : names) {
          method_options.method = name;
          const auto method = makeMethod(method_options);
          const auto start = std::chrono::steady_clock::now();
          method->estimate(all.pairs, camera, result);
          const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
          reporter.add(trialRecord(name, ratio, result, pair, truth, seconds.count()).dump());
          progress.advance();
        }
      }
    }
  }
  return reporter.finish();
}

}  // namespace gms_ransac
