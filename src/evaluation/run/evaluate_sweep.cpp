// `evaluate sweep`: how each method's estimator holds out against outliers, on drawn scenes with exact labels, whose
// scores and distances tell right matches from wrong ones with overlap. There is no filter stage, so that the estimator
// meets the given ratio: methods that differ only in the filter have equal results.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "run/evaluate_commands.h"
#include "run/pair_truth.h"
#include "scenes/two_view_scene.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

constexpr double kRatios[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
/// A trial is a success within these errors, degrees: several times what a method reaches without outliers in the least
/// favourable of its repetitions.
constexpr double kRotationLimit = 1, kDirectionLimit = 5;
constexpr double kNoise = 0.35;  ///< standard deviation of each coordinate, pixels: 0.5 between the two images

nlohmann::json trialRecord(const std::string& method, double ratio, const RobustResult& result,
                           const TwoViewScene& scene, double seconds) {
  int correct = 0, kept_correct = 0;
  for (size_t i = 0; i < scene.correct.size(); ++i) {
    correct += scene.correct[i];
    kept_correct += scene.correct[i] && result.inlier[i];
  }
  const PoseError error =
      result.pose_found ? poseError(scene.currentInReference(), result.pose.R, result.pose.t) : PoseError();
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
           "0.9, on correspondences of\ndrawn scenes. Success: rotation within "
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
    RobustResult result;
    TwoViewSceneOptions scene_options;
    scene_options.noise_px = kNoise;
    const uint64_t first_seed = method_options.robust.seed;
    for (const double ratio : kRatios) {
      scene_options.outlier_ratio = ratio;
      for (int trial = 0; trial < repeat; ++trial) {
        scene_options.seed = method_options.robust.seed = first_seed + static_cast<uint64_t>(trial);
        const TwoViewScene scene = makeTwoViewScene(scene_options);
        for (const std::string& name : names) {
          method_options.method = name;
          const auto method = makeMethod(method_options);
          const auto start = std::chrono::steady_clock::now();
          method->estimate(scene.pairs, scene.camera, result);
          const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
          reporter.add(trialRecord(name, ratio, result, scene, seconds.count()).dump());
          progress.advance();
        }
      }
    }
  }
  return reporter.finish();
}

}  // namespace gms_ransac
