// Program: what the match filter costs as a node. Publishes rendered images at a rate, to the nodelet in its own
// process or to match_filter_node in another, and prints latency, rate, processor share and peak memory as a table.
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <cv_bridge/cv_bridge.h>
#include <gms_ransac/Correspondences.h>
#include <gms_ransac/MatchStats.h>
#include <nodelet/loader.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <boost/process.hpp>
#include <boost/program_options.hpp>

#include "gms_ransac/feature_extractor.h"
#include "parameters/parameter.h"
#include "percentile.h"
#include "program.h"
#include "scenes/scene.h"

namespace {

namespace po = boost::program_options;
using namespace gms_ransac;
using Clock = std::chrono::steady_clock;

const std::string kNamespace = "/node_load_graph";
const std::string kFilter = kNamespace + "/match_filter";
constexpr int kWarmUp = 30;          // images before the measurement: buffers grow, the other process loads its code
constexpr int kDistinctImages = 40;  // shown to and fro, so that the motion never jumps
constexpr int kAhead = 4;            // images that wait at the filter when the rate is the filter's own
constexpr std::chrono::seconds kPatience(20);  // without an answer something is wrong

struct LoadOptions {
  std::string extractor;
  double rate = 30;  ///< images per second; 0: as fast as they are answered
  double seconds = 15;
  int features = 2000, threads = 1;
  bool separate = false, drop = false;
};

/// The images and what goes with them, made before anything is measured.
struct Footage {
  std::vector<sensor_msgs::Image> images;
  sensor_msgs::CameraInfo info;
};

Footage render() {
  const Scene scene{SceneOptions()};
  Footage footage;
  Progress progress("rendering image", kDistinctImages);
  footage.info.header.frame_id = "camera";
  for (int i = 0; i < kDistinctImages; ++i) {
    footage.images.push_back(*cv_bridge::CvImage(footage.info.header, "mono8", scene.render(i).image).toImageMsg());
    progress.advance();
  }
  const CameraIntrinsics& k = scene.intrinsics();
  footage.info.width = footage.images[0].width;
  footage.info.height = footage.images[0].height;
  footage.info.distortion_model = "plumb_bob";
  footage.info.D.assign(5, 0);
  footage.info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
  footage.info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  footage.info.P = {k.fx, 0, k.cx, 0, 0, k.fy, k.cy, 0, 0, 0, 1, 0};
  return footage;
}

/// match_filter_node in a process of its own, ended with this object.
struct NodeProcess {
  // rosrun replaces itself with the node, so this process id is the node's.
  boost::process::child child{"rosrun gms_ransac match_filter_node __ns:=" + kNamespace + " __name:=match_filter"};
  ~NodeProcess() {
    kill(child.id(), SIGINT);
    child.wait();
  }
};

/// User and system time of a process and all of its threads, seconds.
double processorSeconds(pid_t pid) {
  clockid_t clock;
  timespec time = {};
  if (clock_getcpuclockid(pid, &clock) == 0) clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// VmHWM, MB of 10^6 bytes; NaN where the kernel does not say.
double peakMegabytes(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(file, line);) {
    if (line.compare(0, 6, "VmHWM:") == 0) return std::stod(line.substr(6)) * 1024 / 1e6;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The camera, which publishes the footage to and fro, each image a new message with the time of its publication as
/// stamp; and the consumer, which is called while it waits for the next one.
class Graph {
 public:
  Graph(ros::NodeHandle& nh, const Footage& footage)
      : footage_(footage),
        info_(nh.advertise<sensor_msgs::CameraInfo>(kNamespace + "/camera_info", 10)),
        image_(nh.advertise<sensor_msgs::Image>(kNamespace + "/image", 100)),
        stats_(nh.subscribe(kFilter + "/stats", 1000, &Graph::onStats, this)),
        correspondences_(nh.subscribe(kFilter + "/correspondences", 1000, &Graph::onCorrespondences, this)) {}

  bool connected() const {
    return info_.getNumSubscribers() > 0 && image_.getNumSubscribers() > 0 && stats_.getNumPublishers() > 0 &&
           correspondences_.getNumPublishers() > 0;
  }
  /// Publishes one image after another for `seconds`, at the rate asked for or as fast as they are answered.
  void stream(double rate, double seconds) {
    const auto start = Clock::now();
    const auto end = start + std::chrono::duration<double>(seconds);
    for (int i = 0; Clock::now() < end && ros::ok(); ++i) {
      if (rate > 0) {
        listen(start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(i / rate)),
               [] { return false; });
      } else if (!waitFor(sent + 1 - kAhead)) {
        throw std::runtime_error("the filter stopped answering");
      }
      publish();
    }
  }
  /// Waits until `count` images are answered or dropped; false when nothing happens for a while.
  bool waitFor(int count) {
    for (int before = handled_; before < count; before = handled_) {
      listen(Clock::now() + kPatience, [&] { return handled_ > before; });
      if (handled_ == before) return false;
    }
    return true;
  }

  int sent = 0, received = 0, answered = 0;
  Clock::time_point last_answer;     ///< what roscpp loses of images that come too fast is never answered
  std::vector<double> latencies_ms;  ///< of correspondences

 private:
  template <typename Done>
  static void listen(Clock::time_point end, const Done& done) {
    for (auto left = end - Clock::now(); left.count() > 0 && !done() && ros::ok(); left = end - Clock::now()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(std::chrono::duration<double>(left).count()));
    }
  }
  void publish() {
    const int last = static_cast<int>(footage_.images.size()) - 1, phase = sent++ % (2 * last);
    auto image =
        boost::make_shared<sensor_msgs::Image>(footage_.images[static_cast<size_t>(std::min(phase, 2 * last - phase))]);
    auto info = boost::make_shared<sensor_msgs::CameraInfo>(footage_.info);
    image->header.stamp = info->header.stamp = ros::Time::now();
    info_.publish(sensor_msgs::CameraInfoConstPtr(info));
    image_.publish(sensor_msgs::ImageConstPtr(image));
  }
  void onStats(const MatchStatsConstPtr& stats) {
    ++answered;
    last_answer = Clock::now();
    received = static_cast<int>(stats->frames_received);
    handled_ = static_cast<int>(stats->frames_processed + stats->frames_dropped);
  }
  void onCorrespondences(const CorrespondencesConstPtr& message) {
    latencies_ms.push_back(1e3 * (ros::Time::now() - message->header.stamp).toSec());
  }

  const Footage& footage_;
  int handled_ = 0;
  ros::Publisher info_, image_;
  ros::Subscriber stats_, correspondences_;
};

void measure(const LoadOptions& options, const Footage& footage, ros::NodeHandle& nh) {
  ros::NodeHandle parameters(kFilter);
  parameters.setParam("extractor", options.extractor);
  parameters.setParam("features", options.features);
  parameters.setParam("threads", options.threads);
  parameters.setParam("drop_frames", options.drop);
  Graph graph(nh, footage);
  std::unique_ptr<NodeProcess> process;
  std::unique_ptr<nodelet::Loader> manager;
  if (options.separate) {
    process = std::make_unique<NodeProcess>();
  } else {
    manager = std::make_unique<nodelet::Loader>(false);
    if (!manager->load(kFilter, "gms_ransac/MatchFilter", {}, {})) throw std::runtime_error("the nodelet did not load");
  }
  const pid_t pid = process ? process->child.id() : getpid();
  const auto patience = Clock::now() + kPatience;
  while (!graph.connected()) {
    if (Clock::now() > patience) throw std::runtime_error("the filter did not connect");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  graph.stream(30, kWarmUp / 30.);
  graph.waitFor(graph.sent);
  graph.answered = 0;
  graph.latencies_ms.clear();
  const int sent_before = graph.sent, received_before = graph.received;
  const double processor_before = processorSeconds(pid);
  const auto start = Clock::now();
  graph.stream(options.rate, options.seconds);
  graph.waitFor(graph.sent);
  const double seconds = std::chrono::duration<double>(graph.last_answer - start).count();
  const double processor = processorSeconds(pid) - processor_before;
  // In the manager's process most memory is that of the footage.
  const int received = graph.received - received_before, lost = graph.sent - sent_before - received;
  std::printf("| %s | %s | %d | %s | %.1f | %d of %d | %d | %.2f | %.2f | %.1f | %s |\n",
              options.separate ? "node" : "manager", options.extractor.c_str(), options.threads,
              options.rate > 0 ? cv::format("%.1f", options.rate).c_str() : "as answered", graph.answered / seconds,
              graph.answered, received, lost, percentile(graph.latencies_ms, 50), percentile(graph.latencies_ms, 99),
              100 * processor / seconds, options.separate ? cv::format("%.1f", peakMegabytes(pid)).c_str() : "-");
  std::fflush(stdout);
  if (manager) manager->unload(kFilter);
  ros::param::del(kFilter);
}

int nodeLoad(const Arguments& arguments) {
  LoadOptions load;
  std::vector<double> rates;
  std::vector<std::string> extractors;
  po::options_description options;
  auto add = options.add_options();
  add("rate", po::value(&rates)->multitoken()->default_value({30, 100, 0}, "30 100 0"),
      "images per second, each in turn; 0: the next image as soon as one is answered");
  add("extractor", po::value(&extractors)->multitoken()->default_value({"simd_orb", "opencv"}, "simd_orb opencv"),
      "each in turn");
  add("seconds", po::value(&load.seconds)->default_value(load.seconds), "measured for each");
  add("features", po::value(&load.features)->default_value(load.features), "keypoints asked for per image");
  add("threads", po::value(&load.threads)->default_value(load.threads), "~threads of the filter");
  add("drop-frames", po::bool_switch(&load.drop), "let the filter skip images; default: every image is answered");
  add("separate", po::bool_switch(&load.separate),
      "match_filter_node in a process of its own; default: the nodelet in the publisher's process");
  const char* usage =
      "node_load [options]\n\nPublishes rendered images to the match filter and prints, for each extractor and rate, a "
      "row of:\nimages answered per second, answered of those that reached the filter, those that roscpp's queues lost "
      "before,\nlatency from the image's stamp to ~correspondences (ms), processor time\nof the filter's process in "
      "percent of one core (in the manager with the publisher in it) and its "
      "peak\nmemory. Needs a ROS master.";
  if (!parseCommandLine(arguments, usage, options)) return 0;
  for (const double rate : rates) {
    if (!(rate >= 0 && rate <= 10000)) {
      throw std::invalid_argument("--rate is " + std::to_string(rate) + "; it must be between 0 and 10000");
    }
  }
  if (!(load.seconds > 0)) throw std::invalid_argument("--seconds must be above 0");
  if (!ros::master::check()) {
    throw std::invalid_argument("no ROS master answers at " + ros::master::getURI() + "; start roscore first");
  }
  // The table is all that goes to stdout.
  if (ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Warn)) {
    ros::console::notifyLoggerLevelsChanged();
  }
  ros::NodeHandle nh;
  const Footage footage = render();
  std::puts(
      "| process | extractor | threads | images/s sent | answered/s | answered | lost by roscpp | p50 ms | p99 "
      "ms | % of a core | peak MB |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|");
  for (const std::string& extractor : extractors) {
    load.extractor = extractor;
    for (const double rate : rates) {
      load.rate = rate;
      measure(load, footage, nh);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // Another node of this name may run at the same time; Ctrl-C ends the program and not only its ROS part.
  ros::init(argc, argv, "node_load", ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
  return gms_ransac::runProgram(argc, argv, nodeLoad);
}
