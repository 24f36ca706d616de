// A folder of measurements: plan.json, and measurements.jsonl with a line for each finished piece of work, so that an
// interruption loses only the pieces at hand.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gms_ransac {

struct WorkFolder {
  std::string path;
  bool resume = false;  ///< goes on with what is there, which has to be of the same plan
};

/// A piece of work, named for the line of progress.
struct WorkUnit {
  std::string name;
  std::function<nlohmann::json()> records;
};

/// Pieces of work by their number in the plan.
using WorkUnits = std::map<int, WorkUnit>;

/// Writes the records of each unit that the folder lacks, `jobs` units side by side, with a line of progress, until
/// Ctrl-C; then the reporter makes its tables of all. `plan`: everything that decides the figures. Returns the exit
/// status. Throws std::invalid_argument for a folder that is not to be gone on with, std::runtime_error where nothing
/// can be written, and the first failure of a unit.
int workThrough(const WorkFolder& folder, const nlohmann::json& plan, WorkUnits units, int jobs,
                const std::vector<std::string>& report);

}  // namespace gms_ransac
