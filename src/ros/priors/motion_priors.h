// Priors of the motion between two images from other sensors (~rotation_prior, ~scale), what is wrong with them, and
// what is learnt by comparing them with the images.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <std_msgs/Header.h>

#include "gms_ransac/robust_result.h"
#include "parameters.h"
#include "priors/rotation_comparison.h"
#include "priors/wheel_check.h"
#include "scale/ground_scale.h"
#include "scale/translation_scale.h"

namespace ros {
class NodeHandle;
}

namespace gms_ransac {

class ImuRotation;
class OdometryInput;
class TfLookup;

/// For diagnostics.
struct PriorReport {
  bool doubtful = false;
  std::string summary;
  std::vector<std::pair<std::string, std::string>> values;
};

/// A pair as measured by the images.
struct PairSeen {
  const std_msgs::Header &reference, &current;
  const RobustResult& seen;
  const Triangulation& points;
  const Camera& camera;
  GroundImages images;
};

/// `reaches` may be called from any thread, `report` from one other than the rest.
class MotionPriors {
 public:
  /// Null if no parameter needs a prior.
  static std::shared_ptr<MotionPriors> make(const ros::NodeHandle& nh, const Parameters& parameters);
  MotionPriors(const ros::NodeHandle& nh, const Parameters& parameters);
  ~MotionPriors();

  /// `arrived`: called when something came that an image may wait for.
  void start(std::function<void()> arrived);
  void stop();
  /// RobustOptions::rolling_shutter_readout: interval around each image for which the gyro is integrated.
  void setReadout(double seconds) { readout_ = seconds; }
  /// Returns true if all samples for an image of this stamp have come.
  bool reaches(const std_msgs::Header& image);

  /// Rotation of the camera between two images, and during their readout. `problem` names what is missing, in a
  /// sentence; empty: nothing.
  std::optional<RotationPrior> rotation(const std_msgs::Header& reference, const std_msgs::Header& current,
                                        std::string& problem);
  /// Compares the last answer of rotation() with the images; `seen` has a pose.
  void learn(const RobustResult& seen);
  /// The length of that pair's translation, with ~scale odometry or ground. `features` 0: it is not known, and
  /// `problem` says why.
  ScaleEstimate length(const PairSeen& pair, std::string& problem);

  PriorReport report();

 private:
  /// The last query, for the comparison.
  struct Asked {
    std::string camera_frame;
    double from = 0, to = 0;
    std::optional<RotationPrior> prior;
  };
  /// Adds the rotation rates of the pair; returns what is missing.
  std::string fillRates(RotationPrior& prior);
  double timeOf(const std_msgs::Header& image) const { return image.stamp.toSec() + parameters_.image_time_offset; }
  ScaleEstimate lengthOfOdometry(const std::string& camera_frame, double from, double to, const RobustResult& seen,
                                 std::string& problem);
  GroundPrior groundPrior(const std::string& camera_frame);
  /// The answer of ~rotation_prior between two times; may be called from any thread. Returns an empty string, or why it
  /// is unknown, as the end of a sentence.
  std::string rotationBetween(const std::string& camera_frame, double from, double to, RotationPrior& prior);

  const Parameters parameters_;
  std::atomic<double> readout_{0};
  std::function<void()> arrived_ = [] {};
  std::shared_ptr<TfLookup> tf_;
  std::unique_ptr<OdometryInput> odometry_;  ///< null: not used
  std::unique_ptr<ImuRotation> imu_;         ///< null: not used

  // Used by the asking thread only.
  Asked asked_;
  WheelCheck wheels_;
  GroundScale ground_;

  std::mutex mutex_;  ///< guards what follows
  RotationComparison comparison_;
  std::string camera_frame_;
  std::string problem_, length_problem_;  ///< of the last pair
  int pairs_by_rates_ = 0;                ///< corrected for the rolling shutter by the gyro
};

}  // namespace gms_ransac
