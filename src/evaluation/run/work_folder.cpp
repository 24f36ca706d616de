#include "run/work_folder.h"

#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "program.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Lines = std::map<int, std::string>;  ///< of each unit

void write(const std::string& file, const Lines& lines, std::ios::openmode mode) {
  std::ofstream stream(file, mode);
  for (const auto& [unit, line] : lines) stream << line << '\n';
  if (!stream.flush()) throw std::runtime_error(file + ": cannot be written; is the disk full?");
}

/// Makes the folder, or reads what is there, without a line that was cut off.
Lines begin(const WorkFolder& folder, const json& plan, const std::string& plan_file, const std::string& file) {
  std::error_code failure;
  fs::create_directories(folder.path, failure);
  if (failure) throw std::runtime_error(folder.path + ": cannot be made (" + failure.message() + ")");
  Lines lines;
  if (!fs::exists(file)) {
    write(plan_file, {{0, plan.dump(1)}}, std::ios::trunc);
    return lines;
  }
  if (!folder.resume) {
    throw std::invalid_argument(folder.path +
                                ": already holds measurements; add --resume to go on, or choose another --out");
  }
  std::ifstream known(plan_file), stream(file);
  if (json::parse(known, nullptr, false) != plan) {
    throw std::invalid_argument(folder.path + ": was measured with other options or sets; choose another --out");
  }
  for (std::string line; std::getline(stream, line);) {
    const json entry = json::parse(line, nullptr, false);
    if (entry.is_object()) lines.emplace(entry.at("unit"), line);
  }
  write(file, lines, std::ios::trunc);
  return lines;
}

/// Gives the records of each unit to `receive`, one at a time, until Ctrl-C. Rethrows the first failure.
void work(const WorkUnits& units, int jobs, const std::function<void(int, const json&)>& receive) {
  Progress progress("pieces of work measured:", static_cast<int>(units.size()));
  auto next = units.begin();
  std::exception_ptr failure;
  std::mutex mutex;
  const auto share = [&] {
    std::unique_lock<std::mutex> lock(mutex);
    while (next != units.end() && !failure && !interrupted()) {
      const auto& [number, unit] = *next++;
      lock.unlock();
      try {
        const json records = unit.records();
        lock.lock();
        receive(number, records);
        progress.advance(unit.name);
      } catch (...) {
        if (!lock) lock.lock();
        failure = std::current_exception();
      }
    }
  };
  std::vector<std::thread> workers;
  for (int j = 1; j < jobs; ++j) workers.emplace_back(share);
  share();
  for (std::thread& worker : workers) worker.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace

int workThrough(const WorkFolder& folder, const json& plan, WorkUnits units, int jobs,
                const std::vector<std::string>& report) {
  const std::string file = folder.path + "/measurements.jsonl";
  const Lines before = begin(folder, plan, folder.path + "/plan.json", file);
  for (const auto& [number, line] : before) units.erase(number);
  bool any = !before.empty();
  watchInterrupts();
  if (!units.empty()) {
    work(units, jobs, [&](int number, const json& records) {
      write(file, {{number, json{{"unit", number}, {"runs", records}}.dump()}}, std::ios::app);
      any = true;
    });
  }
  return statusOrInterrupted(any ? Reporter(report).finish() : 0, "go on with the same command and --resume");
}

}  // namespace gms_ransac
