#include "program.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <stdexcept>

#include <errno.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <boost/lexical_cast.hpp>
#include <opencv2/core/utility.hpp>

#include "camera/camera_info.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;
using std::chrono::milliseconds;

volatile std::sig_atomic_t noted_interrupt = 0;

/// Thrown to end a program after Ctrl-C.
struct Interrupted {};

/// The script next to this program once installed, in scripts/ of the source when run from a build; "" without it.
std::string findReporter() {
  std::error_code none;
  const fs::path here = fs::read_symlink("/proc/self/exe", none).parent_path();
  for (const fs::path& folder : {here, fs::path(GMS_RANSAC_SOURCE_DIR) / "scripts"}) {
    const fs::path script = folder / "evaluate_report.py";
    if (fs::exists(script)) return script.string();
  }
  return "";
}

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string clockText(double seconds) {
  const long whole = std::lround(seconds);
  return cv::format("%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace

std::optional<po::variables_map> parseCommandLine(const Arguments& arguments, const std::string& usage,
                                                  const po::options_description& options,
                                                  const std::vector<Positional>& positional) {
  po::options_description shown("Options"), all;
  shown.add_options()("help,h", "this text");
  for (const auto& option : options.options()) shown.add(option);
  all.add(shown);
  po::positional_options_description places;
  for (const Positional& words : positional) {
    all.add_options()(words.name, words.value);
    places.add(words.name, words.count);
  }
  po::command_line_parser parser(arguments);
  // An option is never guessed by its beginning: --camera would be taken for --camera-info.
  using Style = po::command_line_style::style_t;
  parser.options(all).positional(places).style(Style::unix_style & ~Style::allow_guessing);
  po::variables_map given;
  po::store(parser.run(), given);
  po::notify(given);
  if (given.count("help") == 0) return given;
  std::cout << usage << "\n\n" << shown;
  return std::nullopt;
}

void addDatasetOptions(po::options_description& description, DatasetOptions& dataset) {
  auto add = description.add_options();
  add("intrinsics", po::value(&dataset.intrinsics),
      "fx,fy,cx,cy[,k1,k2,p1,p2[,k3]] equidistant,fx,fy,cx,cy,k1,k2,k3,k4, omnidirectional,fx,fy,cx,cy,xi,k1,k2,p1,p2 "
      "or double_sphere,fx,fy,cx,cy,xi,alpha; overrides the set's own");
  add("topic", po::value(&dataset.topic), "bags: the image topic");
  const auto store = [&dataset](const std::string& text) {
    const std::map<std::string, Rectified> choices = {
        {"auto", Rectified::kAuto}, {"true", Rectified::kTrue}, {"false", Rectified::kFalse}};
    const auto choice = choices.find(text);
    if (choice == choices.end()) {
      throw std::invalid_argument("--input-is-rectified is '" + text + "'; it must be one of auto, true, false");
    }
    dataset.rectified = choice->second;
  };
  add("input-is-rectified", po::value<std::string>()->default_value("auto")->notifier(store),
      "bags: true: the images have no distortion and P is used; false: K and D are used; auto: as the node decides");
}

void requireAtLeastOne(std::initializer_list<std::pair<const char*, int>> options) {
  for (const auto& [name, value] : options) {
    if (value >= 1) continue;
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) + "; it must be at least 1");
  }
}

std::vector<std::string> splitAtCommas(const std::vector<std::string>& lists) {
  std::vector<std::string> parts;
  for (const std::string& list : lists) {
    std::istringstream stream(list);
    for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  }
  return parts;
}

std::vector<int> parsePositives(const std::vector<std::string>& lists, const std::string& option) {
  std::vector<int> numbers;
  for (const std::string& word : splitAtCommas(lists)) {
    int number = 0;
    if (!boost::conversion::try_lexical_convert(word, number) || number < 1) {
      throw std::invalid_argument(option + " holds '" + word + "'; it takes whole numbers from 1 on");
    }
    numbers.push_back(number);
  }
  if (numbers.empty()) throw std::invalid_argument(option + " is empty; it takes whole numbers from 1 on");
  return numbers;
}

int runProgram(int argc, char** argv, int (*program)(const Arguments&)) {
  std::signal(SIGPIPE, SIG_IGN);  // a reporter that has ended must not end the measurements
  try {
    return program(Arguments(argv + 1, argv + argc));
  } catch (const Interrupted&) {
    std::fprintf(stderr, "%s: interrupted\n", program_invocation_short_name);
    return kInterrupted;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program_invocation_short_name, error.what());
    return kBadInput;
  }
}

double secondsOf(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void watchInterrupts() {
  std::signal(SIGINT, [](int) { noted_interrupt = 1; });
}

bool interrupted() { return noted_interrupt != 0; }

int statusOrInterrupted(int status, const std::string& advice) {
  if (!interrupted()) return status;
  std::fprintf(stderr, "interrupted; %s\n", advice.c_str());
  return kInterrupted;
}

Progress::Progress(std::string what, int total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  show();
  if (terminal_) std::fputc('\n', stderr);
}

void Progress::advance(const std::string& name) {
  ++done_;
  name_ = name;
  const auto now = std::chrono::steady_clock::now();
  if (now - shown_ < (terminal_ ? milliseconds(500) : milliseconds(2000))) return;
  shown_ = now;
  show();
}

void Progress::advanceUnlessInterrupted() {
  if (interrupted()) throw Interrupted();
  advance();
}

void Progress::show() const {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = done_ / std::max(seconds, 1e-3);
  const std::string rest = done_ == 0        ? ""
                           : done_ == total_ ? ", " + clockText(seconds)
                                             : ", " + clockText((total_ - done_) / rate) + " left" +
                                                   (name_.empty() ? "" : " (" + name_ + ")");
  std::fprintf(stderr, terminal_ ? "\r%s %d/%d, %.1f a second%s\033[K" : "%s %d/%d, %.1f a second%s\n", what_.c_str(),
               done_, total_, rate, rest.c_str());
  std::fflush(stderr);
}

Reporter::Reporter(const std::vector<std::string>& arguments, const std::string& out) : out_(out) {
  if (!out.empty() && out != "-") {
    file_.open(out);
    if (!file_) throw std::invalid_argument(out + ": cannot be written");
  }
  std::string command = quoted(GMS_RANSAC_PYTHON) + ' ' + quoted(findReporter());
  for (const std::string& argument : arguments) command += ' ' + quoted(argument);
  std::fflush(nullptr);
  const auto handler = std::signal(SIGINT, SIG_IGN);  // inherited: Ctrl-C ends the records, and then comes the report
  pipe_ = popen((command + (out == "-" ? " 1>&2" : "")).c_str(), "w");
  std::signal(SIGINT, handler);
  // Room for the records of some hundred pairs: they are measured before Python has found its modules.
  if (pipe_) fcntl(fileno(pipe_), F_SETPIPE_SZ, 1 << 20);
}

Reporter::~Reporter() {
  if (pipe_) pclose(pipe_);
}

void Reporter::add(const std::string& record, const std::string& reported) {
  if (pipe_) std::fprintf(pipe_, "%s\n", reported.c_str());
  std::ostream& file = out_ == "-" ? std::cout : file_;
  if (!out_.empty() && !(file << record << std::endl)) {
    throw std::runtime_error(out_ + ": writing failed; is the disk full?");
  }
}

int Reporter::finish() {
  const int status = pipe_ ? WEXITSTATUS(pclose(std::exchange(pipe_, nullptr))) : kNoReport;
  if (status == 0 || status == kBadInput) return status;
  const std::string records = out_.empty() || out_ == "-" ? "" : "; the records are complete in " + out_;
  std::fprintf(stderr, "no report: evaluate_report.py is missing or failed%s\n", records.c_str());
  return kNoReport;
}

}  // namespace gms_ransac
