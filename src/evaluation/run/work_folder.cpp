#include "run/work_folder.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "program.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kPlanFile[] = "plan.json";
constexpr char kMeasurementsFile[] = "measurements.jsonl";

/// The number of a line's unit; none when the line was cut off.
std::optional<int> unitOf(const std::string& line) {
  const json entry = json::parse(line, nullptr, false);
  if (entry.is_discarded() || !entry.is_object()) return std::nullopt;
  return entry.at("unit").get<int>();
}

}  // namespace

void WorkFolder::begin(const json& plan, bool resume) {
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
  if (!(stream << plan.dump(1) << '\n').flush()) throw std::runtime_error(file(kPlanFile) + ": cannot be written");
}

void WorkFolder::open() {
  std::ifstream stream(file(kPlanFile));
  if (!stream) throw std::invalid_argument(path_ + ": holds no " + kPlanFile + ", so it is no folder of measurements");
  plan_ = json::parse(stream, nullptr, false);
  if (plan_.is_discarded()) throw std::invalid_argument(file(kPlanFile) + ": is not JSON");
  done_.clear();
  for (const auto& line : lines()) done_.insert(line.first);
}

std::vector<std::pair<int, std::string>> WorkFolder::lines() const {
  std::vector<std::pair<int, std::string>> whole;
  std::ifstream stream(file(kMeasurementsFile));
  for (std::string line; std::getline(stream, line);) {
    if (const std::optional<int> unit = unitOf(line)) whole.emplace_back(*unit, line);
  }
  return whole;
}

void WorkFolder::write(const std::vector<std::string>& lines, bool append) const {
  std::ofstream stream(file(kMeasurementsFile), append ? std::ios::app : std::ios::trunc);
  for (const std::string& line : lines) stream << line << '\n';
  if (!stream.flush()) throw std::runtime_error(file(kMeasurementsFile) + ": cannot be written; is the disk full?");
}

void WorkFolder::append(int unit, const json& records) {
  write({json{{"unit", unit}, {"runs", records}}.dump()}, true);
  done_.insert(unit);
}

void WorkFolder::absorb(const WorkFolder& other) {
  if (other.plan_ != plan_) {
    throw std::invalid_argument(other.path_ + ": was measured with other options or sets than the first folder");
  }
  std::vector<std::string> fresh;
  for (const auto& line : other.lines()) {
    if (done_.insert(line.first).second) fresh.push_back(line.second);
  }
  write(fresh, true);
}

void workThrough(WorkFolder& folder, const std::vector<int>& units, int jobs, const std::function<json(int)>& measure) {
  std::vector<int> todo;
  std::copy_if(units.begin(), units.end(), std::back_inserter(todo), [&](int unit) { return !folder.isDone(unit); });
  if (todo.empty()) return;
  Progress progress("measuring", static_cast<int>(todo.size()));
  std::atomic<size_t> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    try {
      for (size_t i = next++; i < todo.size() && !failed && !InterruptWatch::interrupted(); i = next++) {
        const json records = measure(todo[i]);
        const std::lock_guard<std::mutex> lock(mutex);
        folder.append(todo[i], records);
        progress.advance();
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  };
  std::vector<std::thread> workers;
  for (int j = 1; j < jobs; ++j) workers.emplace_back(work);
  work();
  for (std::thread& worker : workers) worker.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace gms_ransac
