// `evaluate run`: works through one data set, one record a pair and method, and a table of figures at the end.
#include <fstream>
#include <iostream>
#include <stdexcept>

#include <boost/program_options.hpp>

#include "program.h"
#include "run/evaluate_commands.h"
#include "run/experiment.h"
#include "run/pipeline_options.h"
#include "run/record.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

struct RunArguments {
  std::string folder, out, plot;
  int gap = 1, stride = 1, repeat = 1;
  DatasetOptions dataset;
  PipelineArguments pipeline;
};

/// False when only help was asked for.
bool parse(const Arguments& arguments, RunArguments& run) {
  po::options_description options("Options");
  auto add = options.add_options();
  add("help,h", "this text");
  add("gap", po::value(&run.gap)->default_value(run.gap), "frames between reference and current");
  add("stride", po::value(&run.stride)->default_value(run.stride), "frames between one pair and the next");
  add("repeat", po::value(&run.repeat)->default_value(run.repeat), "repetitions, each with the next seed");
  add("out,o", po::value(&run.out), "file for the records, one JSON object a line; - for standard output");
  add("plot", po::value(&run.plot), "file for a plot (.png, .pdf) of errors and inliers over time");
  addDatasetOptions(options, run.dataset);
  run.pipeline.addTo(options, arguments);
  const char* usage =
      "evaluate run DIR [options]\n\nDIR: a TUM or KITTI odometry folder, a folder of image pairs (pairs.txt), or a "
      ".bag.\nWrites a record for each pair and method, and prints a table.";
  if (!parseCommandLine(arguments, usage, options, {{"folder", 1, po::value(&run.folder)}})) {
    return false;
  }
  if (run.folder.empty()) throw std::invalid_argument("no folder or bag given; see evaluate run --help");
  requireAtLeastOne({{"--gap", run.gap}, {"--stride", run.stride}, {"--repeat", run.repeat}});
  return true;
}

/// Each method, repeated with the next seeds.
std::vector<MatchFilterOptions> pipelines(const RunArguments& run) {
  std::vector<MatchFilterOptions> all;
  for (const std::string& method : run.pipeline.methodNames()) {
    for (int repeat = 0; repeat < run.repeat; ++repeat) {
      all.push_back(run.pipeline.options(method));
      all.back().robust.seed += static_cast<uint64_t>(repeat);
    }
  }
  return all;
}

}  // namespace

int evaluateRun(const Arguments& arguments) {
  RunArguments run;
  if (!parse(arguments, run)) return 0;
  const std::vector<MatchFilterOptions> all = pipelines(run);
  const Dataset dataset = Dataset::open(run.folder, run.dataset);
  const std::vector<DatasetPair> pairs = dataset.pairs(run.gap, run.stride);
  if (pairs.empty()) {
    throw std::invalid_argument(run.folder + ": no pair of images " + std::to_string(run.gap) + " apart among its " +
                                std::to_string(dataset.frames().size()));
  }
  std::ofstream file;
  if (!run.out.empty() && run.out != "-") {
    file.open(run.out);
    if (!file) throw std::invalid_argument(run.out + ": cannot be written");
  }
  std::ostream* records = run.out.empty() ? nullptr : run.out == "-" ? &std::cout : &file;
  for (const std::string& remark : remarks(dataset, all.front())) std::cerr << remark << '\n';

  std::vector<std::string> report = {"run"};
  if (!run.plot.empty()) report.insert(report.end(), {"--plot", run.plot});
  Reporter reporter(report, run.out == "-");
  const InterruptWatch watch;
  size_t done = 0;
  {
    Experiment experiment(dataset, all);
    Progress progress("evaluating pair", static_cast<int>(pairs.size()));
    for (; done < pairs.size() && !InterruptWatch::interrupted(); ++done) {
      experiment.run(pairs[done], [&](const Answer& answer) {
        nlohmann::json record = answerRecord(answer.options, answer.result);
        record.update(pairRecord(dataset, pairs[done], run.gap));
        record["repeat"] = answer.pipeline % static_cast<size_t>(run.repeat);
        record["truth"] = truthRecord(answer.truth, answer.reference, answer.current, answer.result);
        reporter.add(record.dump());
        if (!records) return;
        record["correspondences"] = correspondencesRecord(answer.reference, answer.current, answer.result);
        *records << record.dump() << '\n';
      });
      if (records && !records->flush()) throw std::runtime_error(run.out + ": writing failed; is the disk full?");
      progress.advance();
    }
  }
  reporter.finish();
  return statusOrInterrupted(
      0, "the table is of the first " + std::to_string(done) + " of " + std::to_string(pairs.size()) + " pairs");
}

}  // namespace gms_ransac
