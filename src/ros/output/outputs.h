// Every topic and transform the node gives out; costly ones are made only while they have a subscriber.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include "output/message_conversion.h"
#include "output/output_options.h"
#include "output/stereo_feature_stream.h"
#include "quantiles.h"
#include "throttle.h"

namespace gms_ransac {

class OdometryOutput;
class WatchedBroadcaster;

class Outputs {
 public:
  /// Topics are relative to `pnh`. `listeners_changed` is called whenever a subscriber comes or goes.
  Outputs(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters,
          const std::function<void()>& listeners_changed);
  ~Outputs();

  /// Topic of the match image, as remapped.
  static std::string overlayTopic(const ros::NodeHandle& pnh);

  /// Subscribers of all topics together. Transforms have no subscribers to count; the caller knows whether they are on.
  int listeners() const;
  /// To be asked once, when an image comes.
  Wanted wanted(const OutputOptions& options) const;
  // While only ~features and ~stereo_features have subscribers:
  /// True if this image can be skipped, because they do not need it.
  bool skips(const Received& received, const OutputOptions& options);
  /// They may need the right image without its keypoints.
  bool needRightKeypoints() const { return !stereo_stream_ || stereo_stream_->needsKeypoints(); }
  /// As OdometryOutput has it.
  std::optional<OdometryEstimate> popSetPose(const std_msgs::Header& camera);
  /// Why an output could not be published, and the remedy; empty: no problem. From the thread of `publish`.
  std::string problem() const;
  /// As WatchedBroadcaster has it. From any thread.
  std::string refusal();
  /// To be called every second, from a thread that may wait for the master.
  void watch(bool master_answers);

  /// Returns the stats that were published.
  MatchStatsConstPtr publish(const ProcessedFrame& processed, const FrameCounters& counters,
                             const OutputOptions& options);

 private:
  void publishMotion(const ProcessedFrame& processed, const OutputOptions& options);
  void publishMask(const ProcessedFrame& processed);
  void publishPose(const ProcessedFrame& processed, const OutputOptions& options);
  void publishPoints(const ProcessedFrame& processed);
  void publishFeatures(const ProcessedFrame& processed, const FeatureOptions& options);

  image_transport::ImageTransport transport_;
  std::unique_ptr<WatchedBroadcaster> broadcaster_;
  ros::Publisher correspondences_, keypoints_, stats_, relative_pose_, restart_, inlier_points_, markers_;
  ros::Publisher features_, stereo_features_;  ///< the second with ~input stereo
  ros::Publisher learned_mask_;
  LearnedMask mask_;  ///< that was published last
  image_transport::Publisher match_image_;
  std::unique_ptr<OdometryOutput> odometry_;
  const FeatureLayout feature_layout_;
  FeatureStream feature_stream_;
  Quantiles<double> feature_ages_;  ///< of the last message, seconds; zero without a subscriber
  std::optional<StereoFeatureStream> stereo_stream_;
  Overlay overlay_;
  Throttle throttle_;
};

}  // namespace gms_ransac
