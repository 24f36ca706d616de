// `evaluate sweep`: success and effort of every method against the outlier ratio, on the rendered scene's true labels.
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <boost/program_options.hpp>

#include "methods/method.h"
#include "program.h"
#include "run/evaluate_commands.h"
#include "run/outlier_sweep.h"
#include "run/pipeline_options.h"

namespace gms_ransac {

namespace po = boost::program_options;

int evaluateSweep(const Arguments& arguments) {
  OutlierSweepOptions sweep;
  PipelineArguments pipeline;
  std::string out;
  po::options_description options("Options");
  auto add = options.add_options();
  add("help,h", "this text");
  add("matches", po::value(&sweep.matches)->default_value(sweep.matches), "per trial");
  add("noise", po::value(&sweep.noise)->default_value(sweep.noise), "of the current points, pixels");
  add("repeat", po::value(&sweep.repeat)->default_value(sweep.repeat), "trials for each method and outlier ratio");
  add("out,o", po::value(&out), "file for the table, CSV, with the plot beside it; standard output without");
  add("no-plots", "only CSV");
  pipeline.addTo(options, arguments);
  std::ostringstream usage;
  usage << "evaluate sweep [options]\n\nSuccess rate and effort of each method's estimator at outlier ratios of 0.1 to "
           "0.9, on correspondences of the\nrendered scene. Success: rotation within "
        << kSweepRotationLimit << " degree and direction within " << kSweepDirectionLimit
        << " degrees. Without --method all;\noptions of extraction, matching and filter have no effect.";
  const auto given = parseCommandLine(arguments, usage.str(), options);
  if (!given) return 0;
  sweep.methods = parseMethodNames(pipeline.methods);
  sweep.robust = pipeline.options(pipeline.base.method).robust;
  if (sweep.robust.model == ModelType::kHomography) {
    throw std::invalid_argument("--model is 'homography'; the scene is no plane: it must be essential or fundamental");
  }
  sweep.validate();
  if (!out.empty() && !std::ofstream(out)) throw std::invalid_argument("cannot write " + out);
  std::vector<std::string> report = {"sweep"};
  if (!out.empty()) report.insert(report.end(), {"--out", out});
  if (given->count("no-plots")) report.push_back("--no-plots");
  Reporter reporter(report);
  {
    Progress progress("trials", sweepLength(sweep));
    sweepOutliers(sweep, [&](const nlohmann::json& trial) {
      reporter.add(trial.dump());
      progress.advance();
    });
  }
  return reporter.finish() ? 0 : kNoReport;
}

}  // namespace gms_ransac
