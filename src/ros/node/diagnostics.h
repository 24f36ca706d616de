// Messages of the match filter on /diagnostics: input, matches, graph, timing and, with another sensor, priors.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <gms_ransac/MatchStats.h>
#include <ros/time.h>
#include <ros/wall_timer.h>

#include "parameters.h"
#include "priors/motion_priors.h"

namespace diagnostic_updater {
class DiagnosticStatusWrapper;
class Updater;
}  // namespace diagnostic_updater
namespace ros {
class NodeHandle;
}

namespace gms_ransac {

/// Known without an image.
struct NodeReport {
  std::string error;            ///< why no image can arrive, and the remedy
  std::string waiting;          ///< what does not arrive, and the remedy
  std::string mixed;            ///< which input several nodes publish, and the remedy
  std::string idle;             ///< why no image is expected: paused, no subscriber, end of the bag
  std::optional<int> unpaired;  ///< images without a camera_info of their stamp; none: not required
  std::string graph;            ///< problem of the registration, the clock or tf; empty: none
  PriorReport priors;           ///< of other sensors, where there are any
};

/// May be called from any thread. Publishes every ~diagnostic_period by the wall clock: simulated time may stand still.
class Diagnostics {
 public:
  /// `nh`: its callback queue publishes.
  Diagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters);
  ~Diagnostics();

  /// One processed image. `unpaired`: those of the dropped images that had no camera_info of their stamp. Empty: no
  /// problem of an output, no reason to doubt calibration or units.
  void add(const MatchStats& stats, uint32_t unpaired, const std::string& output_problem, const std::string& doubt);
  void update(const NodeReport& report);

 private:
  void describeInput(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describePriors(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describeGraph(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describeTiming(diagnostic_updater::DiagnosticStatusWrapper& status);
  void describeMatches(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::unique_ptr<diagnostic_updater::Updater> updater_;
  const std::string unit_;  ///< of the translations
  std::mutex mutex_;        ///< guards what follows
  NodeReport node_;
  std::string output_problem_, doubt_;
  MatchStats last_;
  int processed_ = 0, failures_ = 0, late_ = 0;        ///< since the last report; late: beyond ~max_milliseconds
  double asked_ = 0;                                   ///< features, their sum
  uint32_t crowded_out_ = 0, crowded_out_before_ = 0;  ///< dropped because newer images came first
  double seconds_ = 0, latency_ = 0;                   ///< sums since the last report
  ros::WallTime last_report_;
  ros::WallTimer timer_;  ///< last: its callback may run until it is gone
};

}  // namespace gms_ransac
