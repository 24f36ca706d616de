// Program: the OpenCV baseline and ours, stage by stage, on the same images in the same run.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include <boost/program_options.hpp>
#include <opencv2/core/version.hpp>

#include "benchmark/benchmark_suite.h"
#include "gms_ransac/simd.h"
#include "methods/method.h"
#include "program.h"
#include "scenes/scene_writer.h"

namespace {

namespace po = boost::program_options;
namespace fs = std::filesystem;
using namespace gms_ransac;

struct BenchmarkArguments {
  std::string folder, features = "1000,2000,3000,5000,10000", threads = "1,all", methods, model = "essential", out;
  int pairs = 12, gap = 1;
  BenchmarkOptions options;
  DatasetOptions dataset;
};

/// "1,all" -> 1 and the number of cores; repeated values count once.
std::vector<int> parseThreads(const std::string& list) {
  std::vector<int> threads;
  for (const std::string& word : splitAtCommas({list})) {
    const int all = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    const int count = word == "all" ? all : parsePositives({word}, "--threads").front();
    if (threads.empty() || threads.back() != count) threads.push_back(count);
  }
  return threads;
}

/// False when only help was asked for.
bool parse(const Arguments& words, BenchmarkArguments& arguments) {
  po::options_description options;
  auto add = options.add_options();
  add("features", withDefault(arguments.features), "keypoints asked for per image");
  add("threads", withDefault(arguments.threads), "threads of both chains");
  add("method,m", po::value(&arguments.methods), "ours to run (default lo_prosac,cp_ransac,gms_ransac)");
  add("model", withDefault(arguments.model), "of our methods: essential or fundamental");
  add("pairs", withDefault(arguments.pairs), "pairs of images, spread over the set");
  add("gap", withDefault(arguments.gap), "frames between reference and current");
  add("repeat", withDefault(arguments.options.repeat), "times each pair is run");
  add("frames", withDefault(arguments.options.frames),
      "frames of the sequence that are run one after the other as well");
  addDatasetOptions(options, arguments.dataset);
  add("out,o", po::value(&arguments.out), "file for the tables (Markdown), besides the screen");
  const char* usage =
      "benchmark [DIR] [options]\n\nTimes cv::ORB, cv::BFMatcher, a dense GMS and OpenCV's robust estimators against "
      "this\npackage, stage by stage and interleaved. DIR: a TUM or KITTI odometry folder, a folder of\nimage pairs "
      "(pairs.txt), or a .bag; without it a rendered scene. Lists are separated by commas.\nThe FAST threshold is 20 "
      "up to 3000 features and 0 above.";
  if (!parseCommandLine(words, usage, options, {{"folder", 1, po::value(&arguments.folder)}})) return false;
  requireAtLeastOne({{"--pairs", arguments.pairs}, {"--gap", arguments.gap}, {"--repeat", arguments.options.repeat}});
  arguments.options.model = parseModelType(arguments.model);
  if (arguments.options.model == ModelType::kHomography) {
    throw std::invalid_argument("--model is homography; it must be essential or fundamental, as in the baseline");
  }
  if (!arguments.methods.empty()) arguments.options.methods = splitAtCommas({arguments.methods});
  for (const std::string& method : arguments.options.methods) findMethod(method);
  return true;
}

/// A folder that goes with the object.
struct TemporaryFolder {
  std::string path = (fs::temp_directory_path() / "gms_ransac_benchmark_XXXXXX").string();

  TemporaryFolder() {
    if (!mkdtemp(path.data())) throw std::runtime_error("cannot make a folder in " + path);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
};

int benchmark(const Arguments& words) {
  BenchmarkArguments arguments;
  if (!parse(words, arguments)) return 0;
  const std::vector<int> features = parsePositives({arguments.features}, "--features");
  const std::vector<int> threads = parseThreads(arguments.threads);
  if (!arguments.out.empty() && !std::ofstream(arguments.out)) {
    throw std::runtime_error("cannot write " + arguments.out);
  }
  const size_t settings = features.size() * threads.size();
  std::cerr << "benchmark: " << (arguments.folder.empty() ? "a rendered scene" : arguments.folder) << " with "
            << arguments.features << " features and " << arguments.threads << " threads, " << settings
            << (settings == 1 ? " setting"
                              : " settings that take up to a minute each (--features 2000 --threads 1: one)")
            << "; the table comes at the end\n";
  watchInterrupts();
  std::optional<TemporaryFolder> rendered;
  if (arguments.folder.empty()) {
    arguments.folder = rendered.emplace().path;
    const int frames = std::max(arguments.pairs + arguments.gap, arguments.options.frames);
    Progress progress("rendering frame", frames);
    writeTumFolder(Scene(SceneOptions()), frames, arguments.folder, [&] { progress.advanceUnlessInterrupted(); });
  }
  const Dataset dataset = Dataset::open(arguments.folder, arguments.dataset);
  const std::vector<DatasetPair> pairs = dataset.spreadPairs(arguments.gap, arguments.pairs);
  if (pairs.empty()) throw std::invalid_argument(dataset.path() + " has no pair of frames with that gap");

  const cv::Size size = dataset.image(pairs.front().current).size();
  std::ostringstream head;
  head << (rendered ? "rendered scene" : dataset.name()) << ", " << size.width << "x" << size.height << ", "
       << pairs.size() << " pairs, gap " << arguments.gap << ", " << arguments.options.repeat << " repetitions; "
       << toString(detectSimdLevel()) << ", OpenCV " << CV_VERSION;
  std::vector<Series> all;
  for (const int thread_count : threads) {
    for (const int feature_count : features) {
      arguments.options.features = feature_count;
      arguments.options.threads = thread_count;
      all.push_back(benchmarkSeries(dataset, pairs, arguments.options));
    }
  }
  return stream(all, "pair", {"benchmark", "--head", head.str(), "--out", arguments.out});
}

}  // namespace

int main(int argc, char** argv) { return gms_ransac::runProgram(argc, argv, benchmark); }
