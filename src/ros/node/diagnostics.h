// Messages of the match filter on /diagnostics: input, matches, graph, timing and, with another sensor, priors.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <gms_ransac/MatchStats.h>
#include <ros/time.h>

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

/// State of the inputs.
struct InputReport {
  std::string error;            ///< why no image can arrive, and the remedy
  std::string waiting;          ///< what does not arrive, and the remedy
  std::string idle;             ///< why no image is expected: paused, no subscriber, end of the bag
  std::optional<int> unpaired;  ///< images without a camera_info of their stamp; none: not required
};

/// May be called from any thread.
class Diagnostics {
 public:
  Diagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters);
  ~Diagnostics();

  /// One processed image. `problem`: of an output.
  void add(const MatchStats& stats, const std::string& problem);
  void setInput(const InputReport& input);
  /// Reason to doubt the calibration; empty: none.
  void setCalibrationDoubt(const std::string& doubt);
  /// Problem of the registration or the clock; empty: none.
  void setGraph(const std::string& problem);
  /// The status "priors" appears with the first call.
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
  const std::string unit_;  ///< of the translations
  std::mutex mutex_;        ///< guards what follows
  InputReport input_;
  std::string graph_problem_, output_problem_, calibration_doubt_;
  std::optional<PriorReport> priors_;
  MatchStats last_;
  int processed_ = 0, failures_ = 0, late_ = 0;  ///< since the last report; late: beyond ~max_milliseconds
  double asked_ = 0;                             ///< features, their sum
  uint32_t dropped_before_ = 0;
  double seconds_ = 0, latency_ = 0;  ///< sums since the last report
  ros::WallTime last_report_;
};

}  // namespace gms_ransac
