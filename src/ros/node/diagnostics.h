// What /diagnostics says about the match filter: input, timing, the quality of the last matches, and
// whether the ROS master knows it.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <gms_ransac/MatchStats.h>
#include <ros/time.h>

#include "priors/motion_priors.h"

namespace diagnostic_updater {
class DiagnosticStatusWrapper;
class Updater;
}  // namespace diagnostic_updater
namespace ros {
class NodeHandle;
}

namespace gms_ransac {

class Diagnostics {
 public:
  Diagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& name);
  ~Diagnostics();

  /// From the worker: one processed image.
  void add(const MatchStats& stats);
  /// What the input waits for (empty: nothing), and whether it is meant to deliver at all.
  void setInput(const std::string& waiting_for, bool subscribed, bool paused);
  /// Images that were left out because no camera_info had their stamp; without a call they are not mentioned.
  void setUnpaired(int images);
  /// Why the calibration in use may be of another camera; empty: no reason.
  void setCalibrationDoubt(const std::string& doubt);
  /// What is wrong with the node's registration or its clock; empty: nothing.
  void setGraph(const std::string& problem);
  /// What became of the priors; without a call there is no such status.
  void setPriors(const PriorReport& report);
  /// Publishes; called about once a second.
  void update();

 private:
  void describeInput(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describePriors(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describeGraph(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describeTiming(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describeMatches(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::unique_ptr<diagnostic_updater::Updater> updater_;
  std::mutex mutex_;  ///< guards what follows
  std::string waiting_for_, graph_problem_, calibration_doubt_;
  std::optional<PriorReport> priors_;
  std::optional<int> unpaired_;
  bool subscribed_ = false, paused_ = false;
  MatchStats last_;
  int processed_ = 0, failures_ = 0, late_ = 0;  ///< since the last report; late: beyond ~max_milliseconds
  double asked_ = 0;                             ///< features, their sum
  uint32_t dropped_before_ = 0;
  double seconds_ = 0, latency_ = 0;  ///< sums since the last report
  ros::WallTime last_report_;
};

}  // namespace gms_ransac
