// Images that wait until what belongs to them has come. Knows no topic.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include <ros/time.h>

#include "input/image_with_info.h"

namespace gms_ransac {

struct WaitingOptions {
  bool for_camera_info = false;  ///< the first images wait until any camera_info has come
  bool for_right_info = false;   ///< ... and until any of the right camera has
  bool for_mask = false;         ///< an image waits for the mask of its stamp; else the newest goes with it
  double patience = 1;           ///< seconds of the caller's clock that an image waits
  /// Whether other sensors have reached an image's stamp; not set: there are none.
  std::function<bool(const std_msgs::Header&)> sensors_reach;
  /// Seconds that an image waits for them. Once one has waited in vain none does, until they are so late no more.
  double sensor_patience = 0.2;
  size_t capacity = 10;  ///< images that wait, and masks
};

/// Every image comes out once, in the order it came in. One that need not wait comes out at once.
class WaitingImages {
 public:
  explicit WaitingImages(const WaitingOptions& options) : options_(options) {}

  /// `now`: seconds of a clock that never goes back. An image that has a camera_info keeps it.
  void add(const ImageWithInfo& input, double now);
  /// Goes with every image that comes out from now on without one of its own.
  void setCameraInfo(const sensor_msgs::CameraInfoConstPtr& info);
  void setRightInfo(const sensor_msgs::CameraInfoConstPtr& info) { latest_right_info_ = info; }
  void addMask(const sensor_msgs::ImageConstPtr& mask);
  /// Returns the settled images, each once.
  std::vector<ImageWithInfo> settled(double now);
  /// Time alone will decide something: ask settled() again, whether or not anything comes.
  bool pending() const { return !waiting_.empty() || passed_; }
  /// An image waited in vain for the first camera_info; none waits for it again.
  bool gaveUpCameraInfo() const { return gave_up_camera_info_; }
  /// No camera_info of the right camera has come, and one is needed.
  bool lacksRightInfo() const { return options_.for_right_info && !latest_right_info_; }
  /// The sensors are behind: an image waited for them in vain.
  bool gaveUpSensors() const { return gave_up_sensors_; }
  /// Forgets the images that wait.
  void clear();

 private:
  struct Waiting {
    ImageWithInfo input;
    double since;
  };

  /// An image that did not wait for the sensors.
  struct Passed {
    std_msgs::Header header;
    double since;
  };

  bool lacksCameraInfo(const ImageWithInfo& input) const;
  /// The oldest has to wait for sensors.
  bool waitsForSensors(double now);
  /// True if an image that did not wait for the sensors would have waited long enough.
  void watchSensors(double now);
  /// The mask that goes with the image; null: none.
  sensor_msgs::ImageConstPtr maskOf(const sensor_msgs::Image& image) const;
  /// The mask of an image with that stamp can come no more: a later one has.
  bool masksPassed(const ros::Time& stamp) const;
  /// The oldest need wait no longer.
  bool overdue(double now) const;

  const WaitingOptions options_;
  std::deque<Waiting> waiting_;
  std::deque<sensor_msgs::ImageConstPtr> masks_;  ///< in the order they came
  sensor_msgs::CameraInfoConstPtr latest_info_, latest_right_info_;
  bool gave_up_camera_info_ = false, gave_up_sensors_ = false;
  std::optional<Passed> passed_;
};

}  // namespace gms_ransac
