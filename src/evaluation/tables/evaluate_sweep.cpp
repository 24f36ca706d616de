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
#include "tables/tables_report.h"

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
  std::string model = "essential", out;
  po::options_description options("Options");
  auto add = options.add_options();
  add("help,h", "this text");
  add("method,m", po::value(&sweep.methods)->composing(), "method, or several with commas between; all without");
  add("model", po::value(&model)->default_value(model), "essential or fundamental");
  add("matches", po::value(&sweep.matches)->default_value(sweep.matches), "per trial");
  add("noise", po::value(&sweep.noise)->default_value(sweep.noise), "of the current points, pixels");
  add("repeat", po::value(&sweep.repeat)->default_value(sweep.repeat), "trials for each method and outlier ratio");
  add("confidence", po::value(&sweep.robust.confidence)->default_value(sweep.robust.confidence), "of a clean sample");
  add("max-iterations", po::value(&sweep.robust.max_iterations)->default_value(sweep.robust.max_iterations),
      "cap on samples");
  add("ratio", po::value(&sweep.robust.ratio)->default_value(sweep.robust.ratio),
      "cp_ransac: share of the confident group");
  add("quality", po::value(&sweep.robust.quality), "ordered methods: score, support, distance or ratio");
  add("refine", po::value(&sweep.robust.refine)->default_value(sweep.robust.refine), "0: textbook");
  add("seed", po::value(&sweep.robust.seed)->default_value(sweep.robust.seed), "same seed, same result");
  add("out,o", po::value(&out), "file for the table, CSV, with the plot beside it; standard output without");
  add("no-plots", "only CSV");
  po::variables_map given;
  po::store(po::command_line_parser(arguments).options(options).positional(po::positional_options_description()).run(),
            given);
  po::notify(given);
  if (given.count("help")) {
    std::cout << "evaluate sweep [options]\n\nSuccess rate and effort of each method's estimator at outlier ratios "
                 "of 0.1 to 0.9, on correspondences of the\nrendered scene. Success: rotation within "
              << kSweepRotationLimit << " degree and direction within " << kSweepDirectionLimit << " degrees.\n\n"
              << options;
    return 0;
  }
  sweep.methods = parseMethodNames(sweep.methods);
  sweep.robust.model = parseModelType(model);
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
  if (!out.empty() && !given.count("no-plots")) plotTables(out);
  return 0;
}

}  // namespace gms_ransac
