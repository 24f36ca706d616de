// A folder of measurements: plan.json, and measurements.jsonl with a line for each finished piece of work, so that an
// interruption loses only the pieces at hand.
#pragma once

#include <functional>
#include <ios>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace gms_ransac {

class WorkFolder {
 public:
  explicit WorkFolder(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  const nlohmann::json& plan() const { return plan_; }

  /// Makes the folder for measurements of this plan. With `resume` it goes on with one that has the same plan, without
  /// a line that was cut off. Throws std::invalid_argument or std::runtime_error.
  void begin(const nlohmann::json& plan, bool resume);
  /// Opens a folder that `begin` made. Throws std::invalid_argument for any other.
  void open();

  bool isDone(int unit) const { return lines_.count(unit) > 0; }
  size_t unitsDone() const { return lines_.size(); }
  /// Writes the records of a unit, an array, as one line.
  void append(int unit, const nlohmann::json& records);
  /// Takes over the units of another folder that are not here yet. Throws std::invalid_argument for another plan.
  void absorb(const WorkFolder& other);

 private:
  using Lines = std::map<int, std::string>;  ///< of each unit

  std::string file(const std::string& name) const { return path_ + "/" + name; }
  void add(Lines lines);
  void write(const Lines& lines, std::ios::openmode mode) const;

  std::string path_;
  nlohmann::json plan_;
  Lines lines_;
};

/// Appends the records that `measure` makes of each unit that the folder lacks, `jobs` units side by side, with a line
/// of progress, until Ctrl-C. Rethrows the first failure.
void workThrough(WorkFolder& folder, const std::vector<int>& units, int jobs,
                 const std::function<nlohmann::json(int)>& measure);

}  // namespace gms_ransac
