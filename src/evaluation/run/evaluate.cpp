// Program: match filters compared on one's own images, without a ROS master.
#include <iostream>
#include <stdexcept>

#include "program.h"
#include "run/evaluate_commands.h"
#include "run/pipeline_options.h"

namespace {

using namespace gms_ransac;

struct Command {
  const char* name;
  const char* summary;
  int (*run)(const Arguments&);
};

constexpr Command kCommands[] = {
    {"run", "work through a data set: a record for each pair and method, and a table", evaluateRun},
    {"sweep", "success and effort of each method against the outlier ratio, on the rendered scene", evaluateSweep},
    {"tables", "the paper's tables and figures on one's own images", evaluateTables},
    {"trust", "how often OK is wrong, and whether covariances are true, on sets and on scenes that try to fool",
     evaluateTrust},
    {"merge", "join the parts that evaluate tables --shard made", evaluateMerge},
};

std::string usage() {
  std::string text = "usage: evaluate COMMAND [options]    (evaluate COMMAND --help tells more)\n";
  for (const Command& command : kCommands) {
    text += "  " + std::string(command.name) + std::string(10 - std::string(command.name).size(), ' ') +
            command.summary + "\n";
  }
  return text + "  --list    the methods that can be compared\n";
}

int evaluate(const Arguments& arguments) {
  const std::string first = arguments.empty() ? "" : arguments.front();
  if (first == "--list") {
    std::cout << methodTable();
    return 0;
  }
  if (first == "--help" || first == "-h") {
    std::cout << usage();
    return 0;
  }
  for (const Command& command : kCommands) {
    if (first == command.name) return command.run(Arguments(arguments.begin() + 1, arguments.end()));
  }
  throw std::invalid_argument((first.empty() ? "no command given" : "unknown command '" + first + "'") +
                              "; see evaluate --help");
}

}  // namespace

int main(int argc, char** argv) {
  return gms_ransac::runProgram("evaluate", [&] { return evaluate(Arguments(argv + 1, argv + argc)); });
}
