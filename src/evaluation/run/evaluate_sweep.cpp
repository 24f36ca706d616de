// `evaluate sweep`: how each method's estimator holds out against outliers, on drawn scenes with exact labels, whose
// scores and distances tell right matches from wrong ones with overlap. There is no filter stage, so that the estimator
// meets the given ratio: methods that differ only in the filter have equal results.
#include <fstream>
#include <stdexcept>

#include "run/evaluate_commands.h"
#include "run/series.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

constexpr double kRatios[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};

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
  const char* usage =
      "evaluate sweep [options]\n\nSuccess rate and effort of each method's estimator at outlier ratios of 0.1 to 0.9, "
      "on correspondences of\ndrawn scenes. Success: rotation within 1 degree and direction within 5 degrees. Without "
      "--method all;\noptions of extraction, matching and filter have no effect.";
  const auto given = parseCommandLine(arguments, usage, options);
  if (!given) return 0;
  const Pipelines pipelines = pipeline.pipelines(allMethodNames());
  if (pipelines.front().robust.model == ModelType::kHomography) {
    throw std::invalid_argument("--model is 'homography'; the scene is no plane: it must be essential or fundamental");
  }
  requireAtLeastOne({{"--repeat", repeat}});
  if (!out.empty() && !std::ofstream(out)) throw std::invalid_argument("cannot write " + out);
  std::vector<std::string> report = {"sweep"};
  if (!out.empty()) report.insert(report.end(), {"--out", out});
  if (given->count("no-plots")) report.push_back("--no-plots");
  std::vector<Series> all;
  for (const double ratio : kRatios) all.push_back(outlierSeries(ratio, repeat, pipelines));
  Reporter reporter(report);
  return stream(all, "trial", reporter);
}

}  // namespace gms_ransac
