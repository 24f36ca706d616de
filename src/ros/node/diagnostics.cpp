#include "node/diagnostics.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

namespace gms_ransac {

namespace {

using diagnostic_msgs::DiagnosticStatus;
using StatusWrapper = diagnostic_updater::DiagnosticStatusWrapper;

// Below this share of inliers among the filtered matches the motion is doubtful: half the matches disagree with it.
constexpr float kDoubtfulInlierRatio = 0.5f;

// Share of a second's images; ~max_milliseconds allows a late one now and then.
constexpr double kMostLate = 0.1;

bool failed(uint8_t status) {
  return status == MatchStats::TOO_FEW_KEYPOINTS || status == MatchStats::TOO_FEW_MATCHES ||
         status == MatchStats::GMS_REJECTED || status == MatchStats::RANSAC_FAILED || status == MatchStats::BAD_IMAGE;
}

/// The first of the summaries that has words.
void summarize(const std::vector<std::pair<uint8_t, std::string>>& summaries, StatusWrapper& status) {
  const auto found =
      std::find_if(summaries.begin(), summaries.end(), [](const auto& summary) { return !summary.second.empty(); });
  status.summary(found->first, found->second);
}

}  // namespace

Diagnostics::Diagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const Parameters& parameters)
    : updater_(std::make_unique<diagnostic_updater::Updater>(nh, pnh, parameters.name)),
      unit_(parameters.givesMetres() ? "metres" : "none; set ~scale to depth, fixed, odometry or ground for metres"),
      last_report_(ros::WallTime::now()) {
  updater_->setHardwareID("none");
  updater_->add("input", this, &Diagnostics::describeInput);
  updater_->add("matches", this, &Diagnostics::describeMatches);
  updater_->add("graph", this, &Diagnostics::describeGraph);
  if (parameters.usesSensors()) updater_->add("priors", this, &Diagnostics::describePriors);
  updater_->add("timing", this, &Diagnostics::describeTiming);  // last: it starts the next period
  timer_ = nh.createWallTimer(ros::WallDuration(parameters.diagnostic_period),
                              [this](const ros::WallTimerEvent& /*event*/) { updater_->force_update(); });
}

Diagnostics::~Diagnostics() { timer_.stop(); }

void Diagnostics::update(const NodeReport& report) {
  std::lock_guard<std::mutex> lock(mutex_);
  node_ = report;
}

void Diagnostics::add(const MatchStats& stats, uint32_t unpaired, const std::string& output_problem,
                      const std::string& doubt) {
  std::lock_guard<std::mutex> lock(mutex_);
  last_ = stats;
  crowded_out_ = stats.frames_dropped - unpaired;
  output_problem_ = output_problem;
  doubt_ = doubt;
  ++processed_;
  failures_ += failed(stats.status) ? 1 : 0;
  late_ += stats.time_budget > 0 && stats.time_total > stats.time_budget ? 1 : 0;
  asked_ += stats.features_asked;
  seconds_ += stats.time_total;
  latency_ += stats.latency;
}

void Diagnostics::describePriors(StatusWrapper& status) {
  std::lock_guard<std::mutex> lock(mutex_);
  status.summary(node_.priors.doubtful ? DiagnosticStatus::WARN : DiagnosticStatus::OK, node_.priors.summary);
  for (const auto& [key, value] : node_.priors.values) status.add(key, value);
}

void Diagnostics::describeGraph(StatusWrapper& status) {
  std::lock_guard<std::mutex> lock(mutex_);
  summarize({{DiagnosticStatus::ERROR, node_.graph},
             {DiagnosticStatus::WARN, output_problem_},
             {DiagnosticStatus::OK, "known to the ROS master"}},
            status);
}

void Diagnostics::describeInput(StatusWrapper& status) {
  std::lock_guard<std::mutex> lock(mutex_);
  summarize({{DiagnosticStatus::ERROR, node_.error},
             {DiagnosticStatus::OK, node_.idle},
             {DiagnosticStatus::WARN, node_.waiting},
             {DiagnosticStatus::WARN, node_.mixed},
             {DiagnosticStatus::WARN, doubt_},
             {DiagnosticStatus::OK, last_.frames_received == 0 ? "no image yet" : "images arrive"}},
            status);
  status.add("frames received", last_.frames_received);
  status.add("frames processed", last_.frames_processed);
  status.add("frames passed over", last_.frames_passed_over);
  status.add("frames dropped", last_.frames_dropped);
  if (node_.unpaired) status.add("frames without camera_info of their stamp", *node_.unpaired);
  status.add("resets", last_.resets);
}

void Diagnostics::describeMatches(StatusWrapper& status) {
  std::lock_guard<std::mutex> lock(mutex_);
  if (!node_.idle.empty()) {
    status.summary(DiagnosticStatus::OK, node_.idle);
  } else if (last_.frames_processed == 0) {
    status.summary(DiagnosticStatus::OK, "no image yet");
  } else if (last_.status == MatchStats::UNCALIBRATED) {
    status.summary(DiagnosticStatus::WARN, "uncalibrated: " + last_.status_text);
  } else if (failed(last_.status)) {
    status.summary(DiagnosticStatus::ERROR, last_.status_text);
  } else if (last_.status == MatchStats::OK && last_.inlier_ratio < kDoubtfulInlierRatio) {
    status.summary(DiagnosticStatus::WARN, "less than half of the filtered matches agree on one motion");
  } else {
    status.summary(DiagnosticStatus::OK, last_.status_text);
  }
  status.add("keypoints", last_.keypoints_current);
  status.add("raw matches", last_.matches_raw);
  status.add("filtered matches", last_.matches_gms);
  status.add("inliers", last_.inliers);
  status.add("inlier ratio", last_.inlier_ratio);
  status.add("median parallax (px)", last_.median_parallax_px);
  status.addf("failed", "%d of %d", failures_, processed_);
  status.add("unit of the translations", unit_);
}

void Diagnostics::describeTiming(StatusWrapper& status) {
  std::lock_guard<std::mutex> lock(mutex_);
  const ros::WallTime now = ros::WallTime::now();
  const double period = std::max((now - last_report_).toSec(), 1e-3);
  const uint32_t dropped = crowded_out_ - crowded_out_before_;
  const int images = std::max(processed_, 1);
  if (dropped > 0) {
    status.summaryf(DiagnosticStatus::WARN,
                    "%u images dropped because newer ones arrived first; lower ~features or set ~max_milliseconds to "
                    "need less time",
                    dropped);
  } else if (late_ > kMostLate * images) {
    status.summaryf(
        DiagnosticStatus::WARN,
        "%d of %d images took longer than ~max_milliseconds (%g), with %.0f features asked for: the image is "
        "too large for it, or the machine has other work",
        late_, processed_, 1e3 * last_.time_budget, asked_ / images);
  } else {
    status.summary(DiagnosticStatus::OK, node_.idle.empty() ? "keeps up" : node_.idle);
  }
  status.addf("rate (Hz)", "%.1f", processed_ / period);
  status.addf("time per image (ms)", "%.2f", 1e3 * seconds_ / images);
  status.addf("latency (ms)", "%.2f", 1e3 * latency_ / images);
  status.add("dropped", dropped);
  if (last_.time_budget > 0) {
    status.addf("beyond ~max_milliseconds", "%d of %d", late_, processed_);
    status.addf("features asked for", "%.0f", asked_ / images);
  }
  last_report_ = now;
  crowded_out_before_ = crowded_out_;
  processed_ = failures_ = late_ = 0;
  seconds_ = latency_ = asked_ = 0;
}

}  // namespace gms_ransac
