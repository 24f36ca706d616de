// Priors of the motion between two images from other sensors (~rotation_prior, ~scale), what is wrong with them, and
// what is learnt by comparing them with the images.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <std_msgs/Header.h>

#include "parameters.h"
#include "priors/prior_source.h"
#include "priors/rotation_comparison.h"

namespace ros {
class NodeHandle;
}

namespace gms_ransac {

class GyroSource;
class TfLookup;

/// A question, and what the source of rotations said.
struct AskedRotation {
  PriorQuery query;
  std::optional<RotationPrior> prior;  ///< with the rotation during the readout where that is wanted
  std::string problem;                 ///< what is missing, in a sentence; empty: nothing
};

/// One source of rotations and one of lengths at most. `reaches` may be called from any thread, `report` from one other
/// than the rest.
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
  /// RobustOptions::rolling_shutter_readout.
  void setReadout(double seconds);
  /// Returns true if all samples for an image of this stamp have come.
  bool reaches(const std_msgs::Header& image);

  /// Rotation of the camera between two images, and during their readout.
  AskedRotation rotation(const std_msgs::Header& reference, const std_msgs::Header& current);
  /// Compares that answer with the images; `seen` has a pose.
  void compare(const AskedRotation& asked, const RobustResult& seen);
  /// The length of a pair's translation, with ~scale odometry or ground. `features` 0: it is not known, and `problem`
  /// says why.
  ScaleEstimate length(const std_msgs::Header& reference, const std_msgs::Header& current, const PairSeen& pair,
                       std::string& problem);

  /// Takes milliseconds.
  PriorReport report();

 private:
  PriorQuery queryOf(const std_msgs::Header& reference, const std_msgs::Header& current) const;

  const double image_time_offset_;
  std::atomic<double> readout_{0};
  std::unique_ptr<TfLookup> tf_;  ///< null: not used
  std::shared_ptr<GyroSource> gyro_;
  std::shared_ptr<RotationSource> rotation_;  ///< null: none; `gyro_`, if that is one
  std::shared_ptr<LengthSource> length_;      ///< null: none

  std::mutex mutex_;  ///< guards what follows
  RotationComparison comparison_;
  std::string camera_frame_;
  std::string problem_, length_problem_;  ///< of the last pair
  int pairs_by_rates_ = 0;                ///< corrected for the rolling shutter by the gyro
};

}  // namespace gms_ransac
