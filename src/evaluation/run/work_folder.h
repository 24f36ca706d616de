// A folder of measurements: plan.json, and measurements.jsonl with a line for each finished piece of work, so that an
// interruption loses only the pieces at hand.
#pragma once

#include <string>
#include <vector>

#include <boost/program_options.hpp>
#include <nlohmann/json.hpp>

#include "run/series.h"

namespace gms_ransac {

struct WorkFolder {
  std::string path;
  size_t pairs_of_piece;         ///< a piece of work: so many neighbouring pairs of a series
  bool resume = false;           ///< goes on with what is there, which has to be of the same plan
  int jobs = 1;                  ///< pieces measured side by side
  size_t shard = 1, shards = 1;  ///< which part of the pieces, from 1, and of how many

  /// Adds --out and --resume.
  void addTo(boost::program_options::options_description& description);
};

/// Writes the records of each piece of work that the folder lacks, with a line of progress, until Ctrl-C; then the
/// reporter makes its tables of all. `plan`: everything that decides the figures. Returns the exit status. Throws
/// std::invalid_argument for a folder that is not to be gone on with, std::runtime_error where nothing can be written,
/// and the first failure of a piece.
int workThrough(const WorkFolder& folder, const nlohmann::json& plan, const std::vector<Series>& all,
                const std::vector<std::string>& report);

}  // namespace gms_ransac
