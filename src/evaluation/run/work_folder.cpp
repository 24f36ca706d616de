#include "run/work_folder.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
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

}  // namespace

void WorkFolder::begin(const json& plan, bool resume) {
  std::error_code failure;
  fs::create_directories(path_, failure);
  if (failure) throw std::runtime_error(path_ + ": cannot be made (" + failure.message() + ")");
  if (!fs::exists(file(kMeasurementsFile))) {
    plan_ = plan;
    std::ofstream stream(file(kPlanFile));
    if (!(stream << plan.dump(1) << '\n').flush()) throw std::runtime_error(file(kPlanFile) + ": cannot be written");
    return;
  }
  if (!resume) {
    throw std::invalid_argument(path_ + ": already holds measurements; add --resume to go on, or choose another --out");
  }
  open();
  if (plan_ != plan) {
    throw std::invalid_argument(path_ + ": was measured with other options or sets; choose another --out");
  }
  write(lines_, std::ios::trunc);
}

void WorkFolder::open() {
  std::ifstream plan(file(kPlanFile));
  if (!plan) throw std::invalid_argument(path_ + ": holds no " + kPlanFile + ", so it is no folder of measurements");
  plan_ = json::parse(plan, nullptr, false);
  if (plan_.is_discarded()) throw std::invalid_argument(file(kPlanFile) + ": is not JSON");
  lines_.clear();
  std::ifstream stream(file(kMeasurementsFile));
  for (std::string line; std::getline(stream, line);) {
    const json entry = json::parse(line, nullptr, false);
    if (entry.is_object()) lines_.emplace(entry.at("unit"), line);  // else it was cut off
  }
}

void WorkFolder::write(const Lines& lines, std::ios::openmode mode) const {
  std::ofstream stream(file(kMeasurementsFile), mode);
  for (const auto& [unit, line] : lines) stream << line << '\n';
  if (!stream.flush()) throw std::runtime_error(file(kMeasurementsFile) + ": cannot be written; is the disk full?");
}

void WorkFolder::add(Lines lines) {
  for (auto line = lines.begin(); line != lines.end();)
    line = isDone(line->first) ? lines.erase(line) : std::next(line);
  write(lines, std::ios::app);
  lines_.merge(lines);
}

void WorkFolder::append(int unit, const json& records) {
  add({{unit, json{{"unit", unit}, {"runs", records}}.dump()}});
}

void WorkFolder::absorb(const WorkFolder& other) {
  if (other.plan_ != plan_) {
    throw std::invalid_argument(other.path_ + ": was measured with other options or sets than the first folder");
  }
  add(other.lines_);
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
      for (size_t i = next++; i < todo.size() && !failed && !interrupted(); i = next++) {
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
