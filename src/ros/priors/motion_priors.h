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

#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include "gms_ransac/robust_result.h"
#include "parameters.h"
#include "priors/gyro_bias.h"
#include "priors/motion_track.h"
#include "priors/rotation_comparison.h"
#include "priors/wheel_check.h"
#include "scale/ground_scale.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

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
  /// Null if no parameter needs a prior. Reads the topics `imu` and `prior_odom` of `nh` where they are needed.
  static std::shared_ptr<MotionPriors> make(const ros::NodeHandle& nh, const Parameters& parameters);
  MotionPriors(const ros::NodeHandle& nh, const Parameters& parameters);
  /// Without a graph: the ground alone, with ~scale ground.
  explicit MotionPriors(const Parameters& parameters);
  ~MotionPriors();

  /// Subscribes, and forgets what came before. `arrived`: called when something came that an image may wait for.
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

  /// Takes milliseconds.
  PriorReport report();

 private:
  /// The last query, for the comparison.
  struct Asked {
    std::string camera_frame;
    double from = 0, to = 0;
    std::optional<RotationPrior> prior;
  };
  /// A sensor with a topic.
  template <typename Track>
  struct Sensor {
    Track track;
    std::string topic, frame;  ///< resolved; of the axes
    std::string defect;        ///< of the messages, and the remedy; empty: none
    int refused = 0;           ///< messages in a row, up to the last one, with impossible numbers

    void note(bool used) { refused = used ? 0 : refused + 1; }
  };
  bool byGyro() const { return parameters_.rotation_prior == RotationPriorKind::kImu; }
  bool byWheels() const {
    return parameters_.scale == ScaleMode::kOdometry || parameters_.rotation_prior == RotationPriorKind::kOdom;
  }
  double timeOf(const std_msgs::Header& image) const { return image.stamp.toSec() + parameters_.image_time_offset; }

  // Measurements between two times, in seconds of the sensor's clock. Each returns an empty string, or the end of
  // a sentence that says why it is unknown. May be called from any thread.
  /// Rotation of the camera by ~rotation_prior.
  std::string rotationBetween(const std::string& camera_frame, double from, double to, RotationPrior& prior);
  std::string gyroBetween(const std::string& camera_frame, double from, double to, RotationPrior& prior);
  std::string odometryBetween(const std::string& camera_frame, double from, double to, TrackMotion& motion);
  /// Motion of the sensor in its own axes, and the camera in these; with sensors_mutex_ held.
  template <typename Track>
  std::string sensorBetween(const Sensor<Track>& sensor, const std::string& camera_frame, double from, double to,
                            TrackMotion& motion, Eigen::Isometry3d& camera_in_sensor);

  /// Learns the bias of the gyro from the rotation that the images show.
  void learnBias(const RotationPrior& visual);
  /// Adds the rotation rates of the pair; returns what is missing.
  std::string fillRates(RotationPrior& prior);
  ScaleEstimate lengthOfOdometry(const std::string& camera_frame, double from, double to, const RobustResult& seen,
                                 std::string& problem);
  GroundPrior groundPrior(const std::string& camera_frame);

  std::optional<ros::NodeHandle> nh_;  ///< none: no graph
  const Parameters parameters_;
  std::atomic<double> readout_{0};
  std::unique_ptr<TfLookup> tf_;  ///< null: not used

  // Used by the asking thread only.
  Asked asked_;
  WheelCheck wheel_check_;

  std::mutex sensors_mutex_;  ///< guards what follows
  Sensor<GyroTrack> gyro_;
  GyroBias bias_;
  Sensor<OdometryTrack> wheels_;

  std::mutex mutex_;  ///< guards what follows
  RotationComparison comparison_;
  std::string camera_frame_;
  std::string problem_, length_problem_;  ///< of the last pair
  int pairs_by_rates_ = 0;                ///< corrected for the rolling shutter by the gyro

  std::vector<ros::Subscriber> subscribers_;  ///< last: their callbacks may run until they are gone
};

}  // namespace gms_ransac
