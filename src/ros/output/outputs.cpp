#include "output/outputs.h"

#include <cv_bridge/cv_bridge.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <std_msgs/Bool.h>
#include <boost/make_shared.hpp>

#include "frames.h"
#include "guard.h"
#include "output/odometry_output.h"
#include "output/output_options.h"
#include "output/point_outputs.h"
#include "output/stereo_output.h"
#include "output/watched_broadcaster.h"

namespace gms_ransac {

namespace {

const std::string kOverlay = "match_image";

}  // namespace

Outputs::Outputs(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters,
                 const std::function<void()>& listeners_changed)
    : transport_(pnh), broadcaster_(std::make_unique<WatchedBroadcaster>(parameters.name)), throttle_(parameters.name) {
  ros::NodeHandle outputs(pnh);
  const ros::SubscriberStatusCallback changed = [listeners_changed](const ros::SingleSubscriberPublisher&) {
    listeners_changed();
  };
  const image_transport::SubscriberStatusCallback image_changed =
      [listeners_changed](const image_transport::SingleSubscriberPublisher&) { listeners_changed(); };
  correspondences_ = outputs.advertise<Correspondences>("correspondences", kPublisherQueue, changed, changed);
  keypoints_ = outputs.advertise<Keypoints>("keypoints", kPublisherQueue, changed, changed);
  stats_ = outputs.advertise<MatchStats>("stats", kPublisherQueue, changed, changed);
  relative_pose_ =
      outputs.advertise<geometry_msgs::PoseWithCovarianceStamped>("relative_pose", kPublisherQueue, changed, changed);
  restart_ = outputs.advertise<std_msgs::Bool>("restart", kPublisherQueue);  // does not cause a subscription
  odometry_ = std::make_unique<OdometryOutput>(nh, outputs, parameters, changed);
  points_ = std::make_unique<PointOutputs>(outputs, parameters, changed);
  if (parameters.input == InputKind::kStereo) {
    stereo_ = std::make_unique<StereoOutput>(outputs, parameters.stereo_features_type, changed);
  }
  match_image_ = transport_.advertise(kOverlay, 1, image_changed, image_changed);
}

Outputs::~Outputs() = default;

std::string Outputs::overlayTopic(const ros::NodeHandle& pnh) { return pnh.resolveName(kOverlay); }

int Outputs::listeners() const {
  int count = static_cast<int>(match_image_.getNumSubscribers()) + odometry_->listeners() + points_->listeners() +
              (stereo_ ? stereo_->listeners() : 0);
  for (const ros::Publisher* publisher : {&correspondences_, &keypoints_, &stats_, &relative_pose_}) {
    count += static_cast<int>(publisher->getNumSubscribers());
  }
  return count;
}

bool Outputs::featuresSuffice(const OutputOptions& options) const {
  const bool transforms = options.publish_odom_tf || (options.publish_relative_tf && broadcaster_->listened());
  const int features = points_->features().listeners() + (stereo_ ? stereo_->listeners() : 0);
  return features > 0 && features == listeners() && !transforms;
}

bool Outputs::rightImageSuffices() const { return !stereo_ || !stereo_->needsKeypoints(); }

bool Outputs::passesOver(const PreparedFrame& frame, const OutputOptions& options) {
  FeatureOutput& features = points_->features();
  const bool of_one = features.listeners() > 0, of_two = stereo_ && stereo_->listeners() > 0;
  return (of_one || of_two) && (!of_one || features.passesOver(frame, options.features)) &&
         (!of_two || stereo_->passesOver(frame, options.features));
}

std::string Outputs::problem() const { return odometry_->problem(); }

void Outputs::expectOdomTf() { odometry_->listen(); }

MatchStatsConstPtr Outputs::publish(const ProcessedFrame& processed, const FrameCounters& counters,
                                    const OutputOptions& options) {
  // The stats are published even if another output fails.
  const auto report = [&](const std::string& what) {
    throttle_.warn("answer", "an answer is published in part: " + what);
  };
  guarded([&] { publishMotion(processed, options); }, report);
  auto stats = boost::make_shared<MatchStats>();
  toMessage(processed, counters, *stats);
  const Quantiles<double>& ages = points_->features().ages();
  stats->feature_age_median = static_cast<float>(ages.median);
  stats->feature_age_p90 = static_cast<float>(ages.p90);
  // In floating point: ros::Duration throws where stamp and clock are 68 years apart.
  stats->latency = static_cast<float>(ros::Time::now().toSec() - processed.current->header.stamp.toSec());
  stats_.publish(stats);
  if (processed.continuity != Continuity::kContinuous) {
    std_msgs::Bool restart;
    restart.data = true;
    restart_.publish(restart);
  }
  overlay_.add(processed);
  if (match_image_.getNumSubscribers() > 0 && processed.status != MatchStats::BAD_IMAGE) {
    guarded([&] { publishOverlay(processed, options.overlay); }, report);
  }
  return stats;
}

void Outputs::publishMotion(const ProcessedFrame& processed, const OutputOptions& options) {
  if (processed.result != nullptr) {
    if (correspondences_.getNumSubscribers() > 0) {
      auto message = boost::make_shared<Correspondences>();
      toMessage(processed, options.publish_rejected, *message);
      correspondences_.publish(message);
    }
    if (processed.poseValid()) publishPose(processed, options);
  }
  odometry_->publish(processed, options.publish_odom_tf);
  points_->publish(processed, options.features);
  if (keypoints_.getNumSubscribers() > 0 && processed.status != MatchStats::BAD_IMAGE) {
    auto message = boost::make_shared<Keypoints>();
    toMessage(processed, *message);
    keypoints_.publish(message);
  }
  if (stereo_) stereo_->publish(processed, options.features);
}

void Outputs::publishPose(const ProcessedFrame& processed, const OutputOptions& options) {
  if (options.publish_relative_tf) broadcaster_->send(relativeTransform(processed.pose, processed.current->header));
  if (relative_pose_.getNumSubscribers() == 0) return;
  auto message = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>();
  message->header = processed.current->header;
  message->header.frame_id = referenceFrame(processed.reference->header.frame_id);
  message->pose = toPoseWithCovariance(processed.pose);
  relative_pose_.publish(message);
}

void Outputs::publishOverlay(const ProcessedFrame& processed, const OverlayOptions& options) {
  const cv::Mat picture = overlay_.draw(processed, options);
  match_image_.publish(cv_bridge::CvImage(processed.current->header, "bgr8", picture).toImageMsg());
}

}  // namespace gms_ransac
