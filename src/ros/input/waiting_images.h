// Images that wait until what belongs to them has come: a second image of about their stamp, camera_info, mask, other
// sensors. Knows no topic.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include <ros/time.h>

#include "input/image_with_info.h"

namespace gms_ransac {

/// The cameras of a stereo pair are triggered together; what the camera does in more time than this passes for
/// disparity.
constexpr double kStereoTolerance = 0.003;  // seconds

struct WaitingOptions {
  /// Where the answer keeps an image, and where its partner from a second stream; null: there is no second stream.
  sensor_msgs::ImageConstPtr ImageWithInfo::*first = &ImageWithInfo::image, ImageWithInfo::*second = nullptr;
  double tolerance = 0.025;      ///< greatest difference of their stamps, seconds
  bool for_camera_info = false;  ///< the first images wait until any camera_info has come
  bool for_right_info = false;   ///< ... and until any of the right camera has
  bool info_of_each = false;     ///< an image waits for the camera_info of its stamp, and is dropped without
  bool for_mask = false;         ///< an image waits for the mask of its stamp; else the newest goes with it
  double patience = 1;           ///< seconds of the caller's clock that an image waits
  /// Whether other sensors have reached an image's stamp; not set: there are none.
  std::function<bool(const std_msgs::Header&)> sensors_reach;
  /// Seconds that an image waits for these sensors. After one has waited in vain none does until they are in time
  /// again.
  double sensor_patience = 0.2;
  size_t capacity = 10;  ///< images that wait, and messages that wait for them
};

/// Every image comes out once, in the order it came in, with the nearest of the second stream, or alone once none can
/// be expected any more. One that need not wait comes out at once. message_filters' ApproximateTime keeps an image
/// without a partner to itself, and throws where stamps are 68 years apart.
class WaitingImages {
 public:
  explicit WaitingImages(const WaitingOptions& options) : options_(options) {}

  /// `now`: seconds of a clock that never goes back; `received`: of the node's. `keypoints`: go with the image.
  void add(const sensor_msgs::ImageConstPtr& image, const ros::Time& received, double now,
           const KeypointsConstPtr& keypoints = nullptr);
  void addSecond(const sensor_msgs::ImageConstPtr& image);
  void addCameraInfo(const sensor_msgs::CameraInfoConstPtr& info);
  void setRightInfo(const sensor_msgs::CameraInfoConstPtr& info) { latest_right_info_ = info; }
  void addMask(const sensor_msgs::ImageConstPtr& mask);
  /// Returns the settled images, each once.
  std::vector<ImageWithInfo> settled(double now);
  /// Time alone will decide something: ask settled() again, whether or not anything comes.
  bool pending() const { return !waiting_.empty() || passed_; }
  /// Images that found one of the second stream, or with `info_of_each` the camera_info of their stamp.
  int matched() const { return matched_; }
  /// Images that were dropped because no camera_info had their stamp.
  int unpaired() const { return unpaired_; }
  /// An image waited in vain for the first camera_info; none waits for it again.
  bool gaveUpCameraInfo() const { return gave_up_camera_info_; }
  /// No camera_info of the right camera has come, and one is needed.
  bool lacksRightInfo() const { return options_.for_right_info && !latest_right_info_; }
  /// Forgets the images that wait, and what came for them.
  void clear();

 private:
  struct Waiting {
    ImageWithInfo input;
    double since;
    bool paired;  ///< with one of the second stream, or with none for good
  };
  using Iterator = std::deque<Waiting>::iterator;

  /// An image that did not wait for the sensors.
  struct Passed {
    std_msgs::Header header;
    double since;
  };

  double stamp(const Waiting& waiting) const { return (waiting.input.*options_.first)->header.stamp.toSec(); }
  /// Gives the images what has come for them.
  void collect(double now);
  /// The one in the second stream for an image, or the end.
  std::deque<sensor_msgs::ImageConstPtr>::iterator nearest(Iterator image);
  /// True if the second stream has passed the image: no later partner can be nearer.
  bool passed(Iterator image) const;
  bool lacksCameraInfo() const;
  /// The oldest has to wait for sensors.
  bool waitsForSensors(double now);
  /// True if an image that did not wait for the sensors would have waited long enough.
  void watchSensors(double now);
  /// A later image has what the oldest lacks, which can come no more.
  template <typename Message>
  bool overtaken(Message ImageWithInfo::*what) const;
  /// The image need wait no longer.
  bool overdue(Iterator image, double now) const;

  const WaitingOptions options_;
  std::deque<Waiting> waiting_;
  std::deque<sensor_msgs::ImageConstPtr> second_, masks_;  ///< in the order of their stamps
  std::deque<sensor_msgs::CameraInfoConstPtr> infos_;
  sensor_msgs::CameraInfoConstPtr latest_right_info_;
  bool gave_up_camera_info_ = false, gave_up_sensors_ = false;
  int matched_ = 0, unpaired_ = 0;
  std::optional<Passed> passed_;
};

}  // namespace gms_ransac
