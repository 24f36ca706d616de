// `evaluate run`: works through one data set, one record a pair and method, and a table of figures at the end.
#include <fstream>
#include <iostream>
#include <map>
#include <stdexcept>

#include <boost/program_options.hpp>

#include "program.h"
#include "run/evaluate_commands.h"
#include "run/experiment.h"
#include "run/pipeline_options.h"
#include "run/summary.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

struct RunArguments {
  std::string folder, out;
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
  addDatasetOptions(options, run.dataset);
  run.pipeline.addTo(options, arguments);
  const char* usage =
      "evaluate run DIR [options]\n\nDIR: a TUM or KITTI odometry folder, a folder of image pairs (pairs.txt), or a "
      ".bag.\nWrites a record for each pair and method, and prints a table.";
  if (!parseCommandLine(arguments, usage, options, {{"folder", 1, po::value(&run.folder)}}, parseOldOption)) {
    return false;
  }
  if (run.folder.empty()) throw std::invalid_argument("no folder or bag given; see evaluate run --help");
  requireAtLeastOne({{"--gap", run.gap}, {"--stride", run.stride}, {"--repeat", run.repeat}});
  return true;
}

std::vector<Contender> contenders(const RunArguments& run) {
  std::vector<Contender> all;
  for (const std::string& method : run.pipeline.methodNames()) {
    for (int repeat = 0; repeat < run.repeat; ++repeat) {
      Contender contender{run.pipeline.options(method), repeat};
      contender.options.robust.seed += static_cast<uint64_t>(repeat);
      all.push_back(contender);
    }
  }
  return all;
}

}  // namespace

int evaluateRun(const Arguments& arguments) {
  RunArguments run;
  if (!parse(arguments, run)) return 0;
  const std::vector<Contender> all = contenders(run);
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
  if (!dataset.intrinsics()) std::cerr << run.folder << ": no intrinsics, so no poses (see --intrinsics)\n";
  if (const auto note = unappliedOption(dataset, all.front().options)) std::cerr << *note << '\n';

  Experiment experiment(dataset, all, dataset.kind() == DatasetKind::kImagePairs ? 0 : run.gap);
  std::map<std::string, std::vector<PairOutcome>> outcomes;
  {
    Progress progress("evaluating pair", static_cast<int>(pairs.size()));
    for (const DatasetPair& pair : pairs) {
      experiment.run(pair, [&](const Answer& answer) {
        const Record record = makeRecord(answer.context, answer.reference, answer.current, answer.result, answer.truth);
        if (records) *records << toJsonLine(record) << '\n';
        outcomes[record.context.method].push_back(outcomeOf(record));
      });
      if (records && !records->flush()) throw std::runtime_error(run.out + ": writing failed; is the disk full?");
      progress.advance();
    }
  }

  std::vector<std::pair<std::string, Summary>> rows;
  for (const std::string& method : run.pipeline.methodNames()) rows.emplace_back(method, summarize(outcomes[method]));
  (run.out == "-" ? std::cerr : std::cout) << summaryTable(rows);
  return 0;
}

}  // namespace gms_ransac
