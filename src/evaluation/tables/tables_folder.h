// A folder of measurements: plan.json, and measurements.jsonl to which finished pieces of work are appended, so that
// whatever ends the program costs at most the piece at hand.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "tables/tables_measure.h"

namespace gms_ransac {

class TablesFolder {
 public:
  explicit TablesFolder(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  /// As planText writes it; empty: none yet.
  const std::string& plan() const { return plan_; }

  /// Makes the folder for measurements of this plan. One that already holds measurements is taken only with `resume`
  /// and the same plan; a line that was cut off is dropped. Throws std::invalid_argument or std::runtime_error.
  void begin(const std::string& plan, bool resume);
  /// Opens a folder that `begin` made. Throws std::invalid_argument when it is none.
  void open();

  bool isDone(int unit) const { return done_.count(unit) > 0; }
  size_t unitsDone() const { return done_.size(); }
  /// Writes all measurements of a unit as one line.
  void append(int unit, const std::vector<Measurement>& measurements);
  /// Takes over the units of another folder that are not here yet. Throws std::invalid_argument for another plan.
  void absorb(const TablesFolder& other);

  /// All measurements, in the order of the plan whatever order they were made in.
  std::vector<Measurement> read() const;

 private:
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  /// The lines that are whole, as unit -> line.
  std::vector<std::pair<int, std::string>> lines() const;
  void write(const std::vector<std::string>& lines, bool append) const;

  std::string path_;
  std::string plan_;
  std::set<int> done_;
};

/// Draws the figures of a folder of tables, or of the CSV file of a sweep, with the installed plotting script; a script
/// that is missing or fails only costs a line on stderr.
void plotTables(const std::string& folder_or_sweep);

}  // namespace gms_ransac
