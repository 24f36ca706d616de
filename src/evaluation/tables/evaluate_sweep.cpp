// `evaluate sweep`: success and effort of every method against the outlier ratio, on the rendered scene's true labels.
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include <boost/program_options.hpp>

#include "program.h"
#include "run/evaluate_commands.h"
#include "run/pipeline_options.h"
#include "tables/outlier_sweep.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

std::string toCsv(const std::vector<OutlierSweepRow>& rows) {
  std::ostringstream csv;
  csv << "method,order,outlier_ratio,trials,success_rate,hypotheses,models_scored,point_evaluations,milliseconds,"
         "precision,recall\n";
  for (const OutlierSweepRow& row : rows) {
    csv << row.method << ',' << (findMethod(row.method).ordered ? "confidence" : "uniform") << ',' << row.outlier_ratio
        << ',' << row.trials << ',' << static_cast<double>(row.successes) / row.trials << ',' << row.hypotheses << ','
        << row.models_scored << ',' << row.point_evaluations << ',' << row.milliseconds << ',' << row.precision << ','
        << row.recall << '\n';
  }
  return csv.str();
}

}  // namespace

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
  const auto given = parseCommandLine(arguments, usage.str(), options, {}, parseOldOption);
  if (!given) return 0;
  sweep.methods = parseMethodNames(pipeline.methods);
  sweep.robust = pipeline.options(pipeline.base.method).robust;
  if (sweep.robust.model == ModelType::kHomography) {
    throw std::invalid_argument("--model is 'homography'; the scene is no plane: it must be essential or fundamental");
  }
  sweep.validate();
  std::ofstream file;
  if (!out.empty()) {
    file.open(out);
    if (!file) throw std::invalid_argument("cannot write " + out);
  }
  std::string csv;
  {
    Progress progress("trials", sweepLength(sweep));
    csv = toCsv(sweepOutliers(sweep, [&] { progress.advance(); }));
  }
  if (!((out.empty() ? std::cout : file) << csv).flush()) throw std::runtime_error(out + ": writing failed");
  if (!out.empty() && !given->count("no-plots")) plotTables(out);
  return 0;
}

}  // namespace gms_ransac
