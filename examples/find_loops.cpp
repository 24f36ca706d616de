// Example subscriber: reports when the camera sees a place again, from the features of the match filter alone.
// A loop goes out on ~loops as gms_ransac/Correspondences: reference is the keyframe, current the image.
//   rosrun gms_ransac find_loops keypoints:=/match_filter/keypoints
#include <algorithm>
#include <cstdio>
#include <string>

#include <ros/ros.h>

#include "gms_ransac/Correspondences.h"
#include "gms_ransac/Keypoints.h"
#include "gms_ransac/keypoints_view.h"
#include "keyframe_store.h"

namespace {

using gms_ransac::Correspondences;
using gms_ransac::Features;
using gms_ransac::Keypoints;

/// The image against the keyframe that it shows again. Of the motion between them nothing is said.
Correspondences loopMessage(const KeyframeStore::Loop& loop, const Features& keyframe, const std_msgs::Header& when,
                            const Features& image, const Keypoints& source) {
  Correspondences message;
  message.header = source.header;
  message.reference_header = when;
  message.width = source.width;
  message.height = source.height;
  message.pixel_space = source.pixel_space;
  message.K = source.K;
  const size_t n = loop.matches.size();
  for (const gms_ransac::Match& match : loop.matches) {
    const cv::Point2f from = keyframe.keypoints[match.reference].pt, to = image.keypoints[match.current].pt;
    message.reference_points.insert(message.reference_points.end(), {from.x, from.y});
    message.current_points.insert(message.current_points.end(), {to.x, to.y});
    message.distance.push_back(match.distance);
  }
  message.confidence.assign(n, 1);
  message.track_id.assign(n, 0);
  message.track_length.assign(n, 0);
  for (auto* unknown : {&message.probability, &message.reference_sigma, &message.current_sigma}) unknown->assign(n, 0);
  message.current_in_reference.pose.orientation.w = 1;
  return message;
}

class LoopFinder {
 public:
  LoopFinder()
      : store_(static_cast<size_t>(std::max(0, ros::param::param("~latest", 10)))),
        loops_(ros::NodeHandle("~").advertise<Correspondences>("loops", 10)) {
    subscriber_ = ros::NodeHandle().subscribe("keypoints", 10, &LoopFinder::onKeypoints, this);
  }

 private:
  void onKeypoints(const Keypoints& message) try {
    if (!store_.isNewView(message.track_id)) return;
    const gms_ransac::KeypointsView<Keypoints> view(message);
    Features image = view.features();
    if (const auto loop = store_.findLoop(image)) {
      const std_msgs::Header& when = headers_[loop->keyframe];
      ROS_INFO_STREAM("the image of " << message.header.stamp << " shows what that of " << when.stamp
                                      << " did: " << loop->matches.size() << " matches");
      loops_.publish(loopMessage(*loop, store_[loop->keyframe], when, image, message));
    }
    store_.add(std::move(image), message.track_id);
    headers_.push_back(message.header);
  } catch (const std::invalid_argument& problem) {
    ROS_WARN_ONCE("%s", problem.what());
  }

  KeyframeStore store_;
  std::vector<std_msgs::Header> headers_;  ///< of the keyframes
  ros::Publisher loops_;
  ros::Subscriber subscriber_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && argv[1] == std::string("--help")) {
    std::puts(
        "find_loops keypoints:=/match_filter/keypoints\n\nReports when the camera sees a place again, and publishes "
        "the loop on ~loops.");
    return 0;
  }
  ros::init(argc, argv, "find_loops");
  LoopFinder finder;
  ros::spin();
  return 0;
}
