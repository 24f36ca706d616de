// Program: plays the images of a bag over and over, as fast as one of the filters that listen answers, and prints a
// line of JSON a second: what was sent, what each filter answered, how late, and what no answer may be. scripts/soak
// runs it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gms_ransac/MatchStats.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <boost/program_options.hpp>
#include <nlohmann/json.hpp>

#include "program.h"
#include "run/metrics.h"

namespace {

namespace po = boost::program_options;
using namespace gms_ransac;
using Clock = std::chrono::steady_clock;

constexpr uint64_t kAhead = 3;  // images that wait at the filter that answers first
// Every filter may be paused: then an image goes out so often all the same.
constexpr std::chrono::milliseconds kPatience(20);
constexpr std::chrono::seconds kReportPeriod(1);

struct Footage {
  std::vector<sensor_msgs::Image::Ptr> images;
  sensor_msgs::CameraInfo::Ptr info;
};

Footage readBag(const std::string& path, const std::string& image_topic, const std::string& info_topic) {
  Footage footage;
  const rosbag::Bag bag(path, rosbag::bagmode::Read);
  for (const rosbag::MessageInstance& message :
       rosbag::View(bag, rosbag::TopicQuery(std::vector<std::string>{image_topic, info_topic}))) {
    if (auto image = message.instantiate<sensor_msgs::Image>()) footage.images.push_back(image);
    if (auto info = message.instantiate<sensor_msgs::CameraInfo>()) footage.info = info;
  }
  if (footage.images.size() < 2) {
    throw std::invalid_argument(path + " holds " + std::to_string(footage.images.size()) + " images on " + image_topic +
                                "; two are needed at least");
  }
  if (!footage.info) throw std::invalid_argument(path + " holds no camera_info on " + info_topic);
  return footage;
}

/// When which image was sent; images of one loop are told apart by their stamps.
class Sent {
 public:
  void add(const ros::Time& stamp) {
    std::lock_guard<std::mutex> lock(mutex_);
    sent_[stamp.toNSec()] = {++count_, Clock::now()};
  }
  /// The number of the image (from 1; 0: it was never sent) and how long ago it was sent.
  std::pair<uint64_t, double> find(const ros::Time& stamp) {
    std::lock_guard<std::mutex> lock(mutex_);
    const auto found = sent_.find(stamp.toNSec());
    if (found == sent_.end()) return {0, 0};
    return {found->second.first, std::chrono::duration<double>(Clock::now() - found->second.second).count()};
  }
  /// Whether an answer shows that the image number `count` - kAhead has been dealt with; waits a while for it.
  void waitFor(uint64_t count) {
    std::unique_lock<std::mutex> lock(mutex_);
    answered_.wait_for(lock, kPatience, [&] { return newest_ + kAhead >= count; });
  }
  void answer(uint64_t number) {
    {
      std::lock_guard<std::mutex> lock(mutex_);
      newest_ = std::max(newest_, number);
    }
    answered_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable answered_;
  std::map<uint64_t, std::pair<uint64_t, Clock::time_point>> sent_;
  uint64_t count_ = 0, newest_ = 0;
};

/// What one filter says of the images, and what is wrong with that.
class Listener {
 public:
  Listener(ros::NodeHandle& nh, const std::string& filter, Sent& sent)
      : filter_(filter), sent_(sent), stats_(nh.subscribe(filter + "/stats", 1000, &Listener::onStats, this)) {}

  const std::string& filter() const { return filter_; }

  nlohmann::json report() {
    std::lock_guard<std::mutex> lock(mutex_);
    nlohmann::json row = {{"answered", answered_},
                          {"received", last_.frames_received},
                          {"processed", last_.frames_processed},
                          {"dropped", last_.frames_dropped},
                          {"resets", last_.resets},
                          {"statuses", statuses_},
                          {"wrong", wrong_}};
    if (!latencies_ms_.empty()) {
      row["p50_ms"] = percentile(latencies_ms_, 50);
      row["p99_ms"] = percentile(latencies_ms_, 99);
    }
    latencies_ms_.clear();
    return row;
  }

 private:
  void onStats(const MatchStatsConstPtr& stats) {
    const auto [number, seconds] = sent_.find(stats->header.stamp);
    {
      std::lock_guard<std::mutex> lock(mutex_);
      judge(*stats, number > 0);
      ++answered_;
      ++statuses_[std::to_string(stats->status)];
      latencies_ms_.push_back(1e3 * seconds);
      last_ = *stats;
    }
    sent_.answer(number);
  }

  void judge(const MatchStats& stats, bool was_sent) {
    if (!was_sent) wrong("answers to images that were never sent");
    if (stats.frames_processed <= last_.frames_processed) wrong("counts of processed images that did not rise");
    if (stats.frames_received < stats.frames_processed + stats.frames_passed_over + stats.frames_dropped)
      wrong("more images answered than came");
    if (stats.inliers > stats.matches_gms || stats.matches_gms > stats.matches_raw) wrong("more inliers than matches");
    for (const float value : {stats.inlier_ratio, stats.median_parallax_px, stats.rms_error_px, stats.time_total}) {
      if (!std::isfinite(value)) wrong("numbers that are not finite");
    }
  }
  void wrong(const std::string& what) { ++wrong_[what]; }

  const std::string filter_;
  Sent& sent_;
  std::mutex mutex_;
  uint64_t answered_ = 0;
  MatchStats last_;
  std::map<std::string, uint64_t> statuses_, wrong_;
  std::vector<double> latencies_ms_;
  ros::Subscriber stats_;
};

class Player {
 public:
  Player(ros::NodeHandle& nh, Footage footage, Sent& sent)
      : footage_(std::move(footage)),
        sent_(sent),
        info_(nh.advertise<sensor_msgs::CameraInfo>("camera_info", 10)),
        image_(nh.advertise<sensor_msgs::Image>("image", 10)) {}

  uint64_t loops() const { return count_ / footage_.images.size(); }
  uint64_t count() const { return count_; }

  /// Stamps are those of the bag: they go back with every loop.
  void publish() {
    const sensor_msgs::Image::Ptr& image = footage_.images[count_ % footage_.images.size()];
    sent_.waitFor(++count_);
    footage_.info->header.stamp = image->header.stamp;
    sent_.add(image->header.stamp);
    info_.publish(*footage_.info);
    image_.publish(*image);
  }

 private:
  const Footage footage_;
  Sent& sent_;
  uint64_t count_ = 0;
  ros::Publisher info_, image_;
};

int play(int argc, char** argv) {
  std::string bag, image_topic, info_topic;
  std::vector<std::string> filters;
  uint64_t images = 0;
  po::options_description options("Options");
  auto add = options.add_options();
  add("help,h", "this text");
  add("bag", po::value(&bag)->required(), "with images and their camera_info");
  add("image-topic", po::value(&image_topic)->default_value("/camera/rgb/image_color"), "in the bag");
  add("info-topic", po::value(&info_topic)->default_value("/camera/rgb/camera_info"), "in the bag");
  add("filters", po::value(&filters)->multitoken()->required(), "names of the filters that listen");
  add("images", po::value(&images)->default_value(0), "sent before it ends; 0: no end");
  po::variables_map given;
  po::store(po::parse_command_line(argc, argv, options), given);
  if (given.count("help")) {
    std::cout << "soak_player --bag BAG --filters NAME... [options]\n\nPlays a bag over and over on image and "
                 "camera_info, as fast as the fastest of the filters answers;\nprints a line of JSON a second. Needs a "
                 "ROS master; see scripts/soak.\n\n"
              << options;
    return 0;
  }
  po::notify(given);
  Footage footage = readBag(bag, image_topic, info_topic);
  if (!ros::master::check()) {
    throw std::invalid_argument("no ROS master answers at " + ros::master::getURI() + "; start roscore first");
  }
  ros::NodeHandle nh;
  Sent sent;
  std::vector<std::unique_ptr<Listener>> listeners;
  listeners.reserve(filters.size());
  for (const std::string& filter : filters) listeners.push_back(std::make_unique<Listener>(nh, filter, sent));
  ros::AsyncSpinner spinner(1);
  spinner.start();
  Player player(nh, std::move(footage), sent);
  const auto start = Clock::now();
  auto next_report = start;
  while (ros::ok() && (images == 0 || player.count() < images)) {
    player.publish();
    if (Clock::now() < next_report) continue;
    next_report += kReportPeriod;
    nlohmann::json line = {{"seconds", std::chrono::duration<double>(Clock::now() - start).count()},
                           {"sent", player.count()},
                           {"loops", player.loops()}};
    for (const auto& listener : listeners) line["filters"][listener->filter()] = listener->report();
    std::cout << line.dump() << std::endl;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "soak_player");
  return gms_ransac::runProgram("soak_player", [&] { return play(argc, argv); });
}
