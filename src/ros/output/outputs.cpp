#include "output/outputs.h"

#include <utility>
#include <vector>

#include <cv_bridge/cv_bridge.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <std_msgs/Bool.h>
#include <boost/algorithm/string/replace.hpp>
#include <boost/make_shared.hpp>

#include "frames.h"
#include "guard.h"
#include "output/odometry_output.h"
#include "output/point_messages.h"
#include "output/watched_broadcaster.h"

namespace gms_ransac {

namespace {

const std::string kOverlay = "match_image";

/// `type`: the name under which the topic is advertised, of a message type with the same fields.
ros::AdvertiseOptions stereoFeatures(const std::string& type, const ros::SubscriberStatusCallback& changed) {
  auto options = ros::AdvertiseOptions::create<StereoFeatures>("stereo_features", kPublisherQueue, changed, changed,
                                                               ros::VoidConstPtr(), nullptr);
  // The md5sum depends on the fields alone. The definition, which bags keep, names the package of the nested type.
  options.datatype = type;
  boost::replace_all(options.message_definition, "gms_ransac/", type.substr(0, type.find('/') + 1));
  return options;
}

Quantiles<double> agesOf(const std::vector<Feature>& features) {
  std::vector<double> ages;
  ages.reserve(features.size());
  for (const Feature& feature : features) ages.push_back(feature.age);
  return quantilesOf(std::move(ages));
}

}  // namespace

Outputs::Outputs(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters,
                 const std::function<void()>& listeners_changed)
    : transport_(pnh),
      broadcaster_(std::make_unique<WatchedBroadcaster>(parameters.name)),
      feature_layout_(parameters.feature_layout),
      feature_stream_(parameters.input),
      throttle_(parameters.name) {
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
  auto mask = ros::AdvertiseOptions::create<sensor_msgs::Image>("learned_mask", 1, changed, changed,
                                                                ros::VoidConstPtr(), nullptr);
  mask.latch = true;
  learned_mask_ = outputs.advertise(mask);
  restart_ = outputs.advertise<std_msgs::Bool>("restart", kPublisherQueue);  // does not cause a subscription
  odometry_ = std::make_unique<OdometryOutput>(nh, outputs, parameters, *broadcaster_, changed);
  if (parameters.input != InputKind::kKeypoints) {  // they are followed in pixels
    features_ = outputs.advertise<sensor_msgs::PointCloud>("features", kPublisherQueue, changed, changed);
  }
  inlier_points_ = outputs.advertise<sensor_msgs::PointCloud2>("inlier_points", kPublisherQueue, changed, changed);
  markers_ = outputs.advertise<visualization_msgs::MarkerArray>("match_markers", kPublisherQueue, changed, changed);
  if (parameters.input == InputKind::kStereo) {
    auto options = stereoFeatures(parameters.stereo_features_type, changed);
    stereo_features_ = outputs.advertise(options);
    stereo_stream_.emplace();
  }
  match_image_ = transport_.advertise(kOverlay, 1, image_changed, image_changed);
}

Outputs::~Outputs() = default;

std::string Outputs::overlayTopic(const ros::NodeHandle& pnh) { return pnh.resolveName(kOverlay); }

int Outputs::listeners() const {
  uint32_t count = match_image_.getNumSubscribers();
  for (const ros::Publisher* publisher : {&correspondences_, &keypoints_, &stats_, &relative_pose_, &inlier_points_,
                                          &markers_, &features_, &stereo_features_, &learned_mask_}) {
    count += publisher->getNumSubscribers();
  }
  return static_cast<int>(count) + odometry_->listeners();
}

Wanted Outputs::wanted(const OutputOptions& options) const {
  Wanted wanted;
  wanted.features = hasSubscriber(features_);
  wanted.stereo_features = hasSubscriber(stereo_features_);
  const bool transforms = options.publish_odom_tf || (options.publish_relative_tf && broadcaster_->listened());
  const auto features = static_cast<int>(features_.getNumSubscribers() + stereo_features_.getNumSubscribers());
  wanted.features_alone = features > 0 && features == listeners() && !transforms;
  wanted.points = hasSubscriber(inlier_points_) ||
                  (match_image_.getNumSubscribers() > 0 && options.overlay.colour == OverlayColour::kDepth);
  return wanted;
}

bool Outputs::skips(const Received& received, const OutputOptions& options) {
  const Wanted& wanted = received.image.wanted;
  return (!wanted.features || feature_stream_.skips(received, options.features)) &&
         (!wanted.stereo_features || stereo_stream_->skips(received, options.features));
}

std::optional<OdometryEstimate> Outputs::popSetPose(const std_msgs::Header& camera) {
  return odometry_->popSetPose(camera);
}

std::string Outputs::problem() const {
  return odometry_->problem().empty() ? broadcaster_->problem() : odometry_->problem();
}

std::string Outputs::refusal() { return broadcaster_->refusal(); }

void Outputs::watch(bool master_answers) { broadcaster_->watch(master_answers); }

MatchStatsConstPtr Outputs::publish(const ProcessedFrame& processed, const FrameCounters& counters,
                                    const OutputOptions& options) {
  // The stats are published even if another output fails.
  const auto report = [&](const std::string& what) {
    throttle_.warn("answer", "an answer is published in part: " + what);
  };
  guarded([&] { publishMotion(processed, options); }, report);
  auto stats = boost::make_shared<MatchStats>();
  toMessage(processed, counters, *stats);
  stats->feature_age_median = static_cast<float>(feature_ages_.median);
  stats->feature_age_p90 = static_cast<float>(feature_ages_.p90);
  // In floating point: ros::Duration throws where stamp and clock are 68 years apart.
  const double latency = ros::Time::now().toSec() - processed.current->image.header.stamp.toSec();
  // Simulated time goes by the steps of /clock, and may be behind the stamp.
  stats->latency = static_cast<float>(std::max(0., latency));
  stats_.publish(stats);
  if (processed.continuity != Continuity::kContinuous) {
    std_msgs::Bool restart;
    restart.data = true;
    restart_.publish(restart);
  }
  overlay_.add(processed);
  if (match_image_.getNumSubscribers() > 0 && processed.status != MatchStats::BAD_IMAGE) {
    const auto draw = [&] {
      const cv::Mat picture = overlay_.draw(processed, options.overlay);
      match_image_.publish(cv_bridge::CvImage(processed.current->image.header, "bgr8", picture).toImageMsg());
    };
    guarded(draw, report);
  }
  return stats;
}

void Outputs::publishMotion(const ProcessedFrame& processed, const OutputOptions& options) {
  if (processed.pair != nullptr) {
    publishMask(processed);
    if (hasSubscriber(correspondences_)) {
      Correspondences message;
      toMessage(processed, options.publish_rejected, message);
      publishShared(correspondences_, std::move(message));
    }
    publishPose(processed, options);
  }
  odometry_->publish(processed, options.publish_odom_tf);
  publishFeatures(processed, options.features);
  publishPoints(processed);
  if (hasSubscriber(keypoints_) && processed.status != MatchStats::BAD_IMAGE) {
    Keypoints message;
    toMessage(processed, message);
    publishShared(keypoints_, std::move(message));
  }
}

void Outputs::publishMask(const ProcessedFrame& processed) {
  const LearnedMask& mask = processed.pair->result.mask;
  if (mask.imageSize().empty() || mask == mask_) return;
  mask_ = mask;
  learned_mask_.publish(cv_bridge::CvImage(processed.current->image.header, "mono8", mask.toImage()).toImageMsg());
}

void Outputs::publishPose(const ProcessedFrame& processed, const OutputOptions& options) {
  if (options.publish_relative_tf && processed.poseValid())
    broadcaster_->send(relativeTransform(processed.pose, processed.current->image.header));
  const RelativePose* pose = processed.posePublished();
  if (pose == nullptr || !hasSubscriber(relative_pose_)) return;
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = processed.current->image.header;
  message.header.frame_id = referenceFrame(processed.pair->reference->image.header.frame_id);
  message.pose = toMessage(toIsometry(*pose), pose->covariance);
  publishShared(relative_pose_, std::move(message));
}

void Outputs::publishFeatures(const ProcessedFrame& processed, const FeatureOptions& options) {
  if (!hasSubscriber(features_)) {
    feature_stream_.reset();
    feature_ages_ = {};
  } else if (const auto features = feature_stream_.next(processed, options)) {
    feature_ages_ = agesOf(*features);
    publishShared(features_, featureMessage(*processed.current, *features, feature_layout_));
  }
  if (!stereo_stream_) return;
  if (!hasSubscriber(stereo_features_)) {
    stereo_stream_->reset();
  } else if (auto features = stereo_stream_->next(processed, options)) {
    publishShared(stereo_features_, std::move(*features));
  }
}

void Outputs::publishPoints(const ProcessedFrame& processed) {
  if (!processed.current->image.camera || !processed.current->image.camera->camera.calibrated()) return;
  if (hasSubscriber(inlier_points_) && processed.status == MatchStats::OK && processed.pair != nullptr &&
      processed.pair->triangulated) {
    publishShared(inlier_points_, pointsMessage(processed, processed.pair->points));
  }
  if (hasSubscriber(markers_)) publishShared(markers_, markerMessage(processed));
}

}  // namespace gms_ransac
