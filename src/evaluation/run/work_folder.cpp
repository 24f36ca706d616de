#include "run/work_folder.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Lines = std::map<size_t, std::string>;  ///< by the number of a piece

struct Piece {
  const Series& series;
  size_t first, last;  ///< pairs
};
using Pieces = std::map<size_t, Piece>;  ///< by their number in the plan

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

Pieces piecesOf(const std::vector<Series>& all, const WorkFolder& folder) {
  Pieces pieces;
  size_t number = 0;
  for (const Series& series : all) {
    for (size_t first = 0; first < series.count; first += folder.pairs_of_piece, ++number) {
      if (number % folder.shards != folder.shard - 1) continue;
      pieces.insert({number, {series, first, std::min(series.count, first + folder.pairs_of_piece)}});
    }
  }
  return pieces;
}

/// Gives the records of each piece to `receive`, one at a time, until Ctrl-C. Rethrows the first failure.
void work(const Pieces& pieces, int jobs, const std::function<void(size_t, const json&)>& receive) {
  Progress progress("pieces of work measured:", static_cast<int>(pieces.size()));
  auto next = pieces.begin();
  std::exception_ptr failure;
  std::mutex mutex;
  const auto share = [&] {
    std::unique_lock<std::mutex> lock(mutex);
    while (next != pieces.end() && !failure && !interrupted()) {
      const auto& [number, piece] = *next++;
      lock.unlock();
      try {
        json all = json::array();
        piece.series.measure(piece.first, piece.last, [&all](Records& records) {
          std::move(records.begin(), records.end(), std::back_inserter(all));
          return true;
        });
        lock.lock();
        receive(number, all);
        progress.advance(piece.series.name);
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

void WorkFolder::addTo(boost::program_options::options_description& description) {
  description.add_options()("out,o", withDefault(path), "folder for measurements, tables and plots")(
      "resume", boost::program_options::bool_switch(&resume), "go on with what is in the folder already");
}

int workThrough(const WorkFolder& folder, const json& plan, const std::vector<Series>& all,
                const std::vector<std::string>& report) {
  const std::string file = folder.path + "/measurements.jsonl";
  const Lines before = begin(folder, plan, folder.path + "/plan.json", file);
  Pieces pieces = piecesOf(all, folder);
  for (const auto& [number, line] : before) pieces.erase(number);
  bool any = !before.empty();
  watchInterrupts();
  if (!pieces.empty()) {
    work(pieces, folder.jobs, [&](size_t number, const json& records) {
      write(file, {{number, json{{"unit", number}, {"runs", records}}.dump()}}, std::ios::app);
      any = true;
    });
  }
  return statusOrInterrupted(any ? Reporter(report).finish() : 0, "go on with the same command and --resume");
}

}  // namespace gms_ransac
