#include "priors/prior_source.h"

#include <cmath>

#include <opencv2/core.hpp>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

// Standard deviation of the rotation between two poses: a floor, radians, and a share of the rotation.
constexpr double kPoseFloor = 0.005, kPoseShare = 0.05;

}  // namespace

RotationAnswer RotationSource::ask(const PriorQuery& query) {
  RotationAnswer answer;
  answer.problem = "the reference is not before the current image";
  if (query.from < query.to) answer = measure(query);
  answer.query = query;
  if (!answer.problem.empty()) {
    answer.problem.insert(0, answer.prior ? "no rotation during the readout: " : "no rotation prior: ");
  }
  std::lock_guard<std::mutex> lock(mutex_);
  history_.last = query;
  history_.problem = answer.problem;
  return answer;
}

void RotationSource::compare(const RotationAnswer& answer, const RobustResult& seen) {
  const PriorQuery& query = answer.query;
  RotationPrior visual;
  visual.R = seen.judgement.pose.R;
  visual.covariance = seen.judgement.pose.covariance.bottomRightCorner<3, 3>();
  calibrate(query, visual);
  std::lock_guard<std::mutex> lock(mutex_);
  history_.pairs_by_rates += seen.row_correction == RowCorrection::kPrior;
  history_.comparison.add({query.from, query.to, rotationVector(visual.R), rotationVector(answer.prior->R),
                           visual.covariance + answer.prior->covariance});
}

PriorReport RotationSource::report() {
  const History history = [this] {
    std::lock_guard<std::mutex> lock(mutex_);
    return history_;
  }();
  const RotationComparison& comparison = history.comparison;
  const auto rotationBetween = [&](double from, double to) -> std::optional<Eigen::Vector3d> {
    const RotationAnswer answer = measure({history.last.camera_frame, from, to});
    return answer.prior ? std::optional(rotationVector(answer.prior->R)) : std::nullopt;
  };
  const std::optional<TimeOffset> offset = comparison.timeOffset(rotationBetween);
  PriorReport report;
  report.summary = comparison.doubt(offset);
  if (report.summary.empty()) report.summary = history.problem;
  report.doubtful = !report.summary.empty();
  if (!report.doubtful) report.summary = comparison.agreement();
  describe(report);
  const auto add = [&](const char* key, const std::string& value) { report.values.emplace_back(key, value); };
  add("pairs compared", std::to_string(comparison.pairs()));
  if (history.last.readout > 0) add("pairs corrected for readout", std::to_string(history.pairs_by_rates));
  add("contradicting", std::to_string(std::lround(100 * comparison.contradicting())) + " %");
  add("~image_time_offset (s)",
      offset ? cv::format("%.4f, standard deviation %.4f", image_time_offset_ + offset->seconds, offset->sigma)
             : "unknown: too little rotation");
  return report;
}

LengthAnswer LengthSource::ask(const PriorQuery& query, const PairSeen& pair) {
  LengthAnswer answer = measure(query, pair);
  std::lock_guard<std::mutex> lock(mutex_);
  problem_ = answer.problem;
  return answer;
}

PriorReport LengthSource::report() {
  std::lock_guard<std::mutex> lock(mutex_);
  PriorReport report;
  report.doubtful = !problem_.empty();
  report.summary = report.doubtful ? "no length: " + problem_ : RotationComparison().agreement();
  return report;
}

RotationPrior priorOfPoses(const Eigen::Matrix3d& R) {
  const double rotation = kPoseShare * rotationVector(R).norm();
  RotationPrior prior;
  prior.R = R;
  prior.covariance.diagonal().setConstant(kPoseFloor * kPoseFloor + rotation * rotation);
  return prior;
}

}  // namespace gms_ransac
