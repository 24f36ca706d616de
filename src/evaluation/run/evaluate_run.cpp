// `evaluate run`: works through one data set, one record a pair and method, and a table of figures at the end.
#include <stdexcept>

#include "run/evaluate_commands.h"
#include "run/experiment.h"

namespace gms_ransac {

namespace po = boost::program_options;

int evaluateRun(const Arguments& arguments) {
  std::string folder, out, plot;
  int gap = 1, stride = 1, repeats = 1;
  DatasetOptions dataset_options;
  PipelineArguments pipeline;
  po::options_description options;
  auto add = options.add_options();
  add("gap", withDefault(gap), "frames between reference and current");
  add("stride", withDefault(stride), "frames between one pair and the next");
  add("repeat", withDefault(repeats), "repetitions, each with the next seed");
  add("out,o", po::value(&out), "file for the records, one JSON object a line; - for standard output");
  add("plot", po::value(&plot), "file for a plot (.png, .pdf) of errors and inliers over time");
  addDatasetOptions(options, dataset_options);
  pipeline.addTo(options, arguments);
  const char* usage =
      "evaluate run DIR [options]\n\nDIR: a TUM or KITTI odometry folder, a folder of image pairs (pairs.txt), or a "
      ".bag.\nWrites a record for each pair and method, and prints a table.";
  if (!parseCommandLine(arguments, usage, options, {{"folder", 1, po::value(&folder)}})) return 0;
  if (folder.empty()) throw std::invalid_argument("no folder or bag given; see evaluate run --help");
  requireAtLeastOne({{"--gap", gap}, {"--stride", stride}, {"--repeat", repeats}});
  std::vector<MatchFilterOptions> pipelines;
  for (const MatchFilterOptions& method : pipeline.pipelines({pipeline.base.method})) {
    for (int repeat = 0; repeat < repeats; ++repeat) {
      pipelines.push_back(method);
      pipelines.back().robust.seed += static_cast<uint64_t>(repeat);
    }
  }
  const Dataset dataset = Dataset::open(folder, dataset_options);
  const std::vector<DatasetPair> pairs = dataset.pairs(gap, stride);
  if (pairs.empty()) {
    throw std::invalid_argument(folder + ": no pair of images " + std::to_string(gap) + " apart among its " +
                                std::to_string(dataset.frames().size()));
  }
  std::vector<std::string> report = {"run"};
  if (!plot.empty()) report.insert(report.end(), {"--plot", plot});
  Reporter reporter(report, out);
  printRemarks(dataset, pipelines.front());
  watchInterrupts();
  size_t done = 0;
  {
    Experiment experiment(dataset, pipelines, defaultTruthNoise(folder));
    Progress progress("evaluating pair", static_cast<int>(pairs.size()));
    for (; done < pairs.size() && !interrupted(); ++done) {
      experiment.run(pairs[done], gap, [&](nlohmann::json& record, const Answer& answer) {
        if (!out.empty()) record["correspondences"] = correspondencesOf(answer);
        reporter.add(record.dump());
      });
      progress.advance();
    }
  }
  reporter.finish();
  return statusOrInterrupted(
      0, "the table is of the first " + std::to_string(done) + " of " + std::to_string(pairs.size()) + " pairs");
}

}  // namespace gms_ransac
