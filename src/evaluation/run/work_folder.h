// A folder of measurements: plan.json, and measurements.jsonl to which finished pieces of work are appended, so that
// whatever ends the program costs at most the pieces at hand.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace gms_ransac {

class WorkFolder {
 public:
  explicit WorkFolder(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  /// JSON without line breaks; empty: none yet.
  const std::string& plan() const { return plan_; }

  /// Makes the folder for measurements of this plan (JSON). One that already holds measurements is taken only with
  /// `resume` and the same plan; a line that was cut off is dropped. Throws std::invalid_argument or
  /// std::runtime_error.
  void begin(const std::string& text, bool resume);
  /// Opens a folder that `begin` made. Throws std::invalid_argument when it is none.
  void open();

  bool isDone(int unit) const { return done_.count(unit) > 0; }
  size_t unitsDone() const { return done_.size(); }
  /// Writes all measurements of a unit, a JSON array, as one line.
  void append(int unit, const std::string& measurements);
  /// Takes over the units of another folder that are not here yet. Throws std::invalid_argument for another plan.
  void absorb(const WorkFolder& other);

  /// What was appended, in the order of the plan whatever order it was made in.
  std::vector<std::string> read() const;

 private:
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  /// The lines that are whole, as unit -> line.
  std::vector<std::pair<int, std::string>> lines() const;
  void write(const std::vector<std::string>& lines, bool append) const;

  std::string path_;
  std::string plan_;
  std::set<int> done_;
};

/// Appends what `measure` makes of each of the units that the folder lacks, `jobs` of them side by side, with a line of
/// progress, until Ctrl-C (InterruptWatch). Rethrows the first failure.
void workThrough(WorkFolder& folder, const std::vector<int>& units, int jobs,
                 const std::function<std::string(int)>& measure);

}  // namespace gms_ransac
