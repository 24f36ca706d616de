#include "tables/tables_folder.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include <sys/wait.h>
#include <unistd.h>

#include "tables/tables_json.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;

constexpr char kPlanFile[] = "plan.json";
constexpr char kMeasurementsFile[] = "measurements.jsonl";
constexpr char kPlotScript[] = "plot_tables.py";

/// Beside this program once installed; in scripts/ of the source when run from a build.
std::string plotScript() {
  std::error_code none;
  const fs::path here = fs::read_symlink("/proc/self/exe", none).parent_path();
  for (const fs::path& candidate : {here / kPlotScript, fs::path(GMS_RANSAC_SOURCE_DIR) / "scripts" / kPlotScript}) {
    if (fs::exists(candidate)) return candidate.string();
  }
  return "";
}

}  // namespace

void TablesFolder::begin(const std::string& plan, bool resume) {
  std::error_code failure;
  fs::create_directories(path_, failure);
  if (failure) throw std::runtime_error(path_ + ": cannot be made (" + failure.message() + ")");
  if (fs::exists(file(kMeasurementsFile))) {
    if (!resume) {
      throw std::invalid_argument(path_ +
                                  ": already holds measurements; add --resume to go on, or choose another --out");
    }
    open();
    if (plan_ != plan) {
      throw std::invalid_argument(path_ + ": was measured with other options or sets; choose another --out");
    }
    std::vector<std::string> whole;
    for (const auto& line : lines()) whole.push_back(line.second);
    write(whole, false);
    return;
  }
  plan_ = plan;
  std::ofstream stream(file(kPlanFile));
  if (!(stream << planForReading(plan) << '\n').flush())
    throw std::runtime_error(file(kPlanFile) + ": cannot be written");
}

void TablesFolder::open() {
  std::ifstream stream(file(kPlanFile));
  if (!stream)
    throw std::invalid_argument(path_ + ": holds no " + kPlanFile + ", so it is no folder of evaluate tables");
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  const std::optional<std::string> plan = planFrom(text);
  if (!plan) throw std::invalid_argument(file(kPlanFile) + ": is not JSON");
  plan_ = *plan;
  done_.clear();
  for (const auto& line : lines()) done_.insert(line.first);
}

std::vector<std::pair<int, std::string>> TablesFolder::lines() const {
  std::vector<std::pair<int, std::string>> whole;
  std::ifstream stream(file(kMeasurementsFile));
  for (std::string line; std::getline(stream, line);) {
    if (const std::optional<int> unit = unitOf(line)) whole.emplace_back(*unit, line);
  }
  return whole;
}

void TablesFolder::write(const std::vector<std::string>& lines, bool append) const {
  std::ofstream stream(file(kMeasurementsFile), append ? std::ios::app : std::ios::trunc);
  for (const std::string& line : lines) stream << line << '\n';
  if (!stream.flush()) throw std::runtime_error(file(kMeasurementsFile) + ": cannot be written; is the disk full?");
}

void TablesFolder::append(int unit, const std::vector<Measurement>& measurements) {
  write({unitLine(unit, measurements)}, true);
  done_.insert(unit);
}

void TablesFolder::absorb(const TablesFolder& other) {
  if (other.plan_ != plan_) {
    throw std::invalid_argument(other.path_ + ": was measured with other options or sets than the first folder");
  }
  std::vector<std::string> fresh;
  for (const auto& line : other.lines()) {
    if (done_.insert(line.first).second) fresh.push_back(line.second);
  }
  write(fresh, true);
}

std::vector<Measurement> TablesFolder::read() const {
  std::vector<std::pair<int, std::string>> all = lines();
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Measurement> measurements;
  for (const auto& line : all) {
    for (Measurement& measurement : measurementsOf(line.second)) measurements.push_back(std::move(measurement));
  }
  return measurements;
}

void plotTables(const std::string& folder_or_sweep) {
  const std::string script = plotScript();
  if (script.empty()) {
    std::fprintf(stderr, "no plots: %s is not installed beside this program\n", kPlotScript);
    return;
  }
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execl(script.c_str(), script.c_str(), folder_or_sweep.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0 || status != 0) {
    std::fprintf(stderr, "no plots: %s failed; the tables are complete\n", script.c_str());
  }
}

}  // namespace gms_ransac
