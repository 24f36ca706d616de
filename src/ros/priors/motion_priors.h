// Priors of the motion between two images from other sensors (~rotation_prior, ~scale): which sources there are, and
// their queries.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include <std_msgs/Header.h>

#include "parameters.h"
#include "priors/prior_source.h"

namespace ros {
class NodeHandle;
}

namespace gms_ransac {

class TfLookup;

/// One source of rotations and one of lengths at most. `reaches` and `report` may be called from any thread, the rest
/// from one.
class MotionPriors {
 public:
  /// Null if no parameter needs a prior. Reads the topics `imu` and `prior_odom` of `nh` where they are needed.
  static std::shared_ptr<MotionPriors> make(const ros::NodeHandle& nh, const Parameters& parameters);
  MotionPriors(const ros::NodeHandle& nh, const Parameters& parameters);
  /// Without a graph: the ground alone, with ~scale ground.
  explicit MotionPriors(const Parameters& parameters);
  ~MotionPriors();

  /// Subscribes, and forgets what came before. `arrived`: called when something came that an image may wait for.
  void start(const std::function<void()>& arrived);
  void stop();
  /// RobustOptions::rolling_shutter_readout. May be called from any thread.
  void setReadout(double seconds) { readout_ = seconds; }
  /// Returns true if all samples for an image of this stamp have come.
  bool reaches(const std_msgs::Header& image) const;
  PriorQuery query(const std_msgs::Header& reference, const std_msgs::Header& current) const;
  PriorReport report() const;

  RotationSource* rotation() const { return rotation_.get(); }  ///< null: none
  LengthSource* length() const { return length_.get(); }        ///< null: none

 private:
  const double image_time_offset_;
  std::atomic<double> readout_{0};
  std::unique_ptr<TfLookup> tf_;  ///< null: not used
  std::shared_ptr<RotationSource> rotation_;
  std::unique_ptr<LengthSource> length_;
};

}  // namespace gms_ransac
