#include "priors/prior_source.h"

#include <cmath>

#include <opencv2/core.hpp>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

// Standard deviation of the rotation between two poses: a floor, radians, and a share of the rotation.
constexpr double kPoseFloor = 0.005, kPoseShare = 0.05;

}  // namespace

PriorQuery RotationSource::onSensorClock(PriorQuery query) const {
  std::lock_guard<std::mutex> lock(mutex_);
  query.from += calibration_.timeOffset();
  query.to += calibration_.timeOffset();
  return query;
}

RotationAnswer RotationSource::ask(const PriorQuery& query) {
  RotationAnswer answer;
  const auto sensor = [&](double from, double to) {
    RotationAnswer measured = measure({query.camera_frame, from, to, answer.prior ? 0 : query.readout});
    if (!answer.prior) answer = measured;
    return measured.prior;
  };
  std::lock_guard<std::mutex> lock(mutex_);
  answer.problem = "the reference is not before the current image";
  if (query.from < query.to) answer.prior = calibration_.correct(sensor, query.from, query.to);
  answer.query = query;
  if (!answer.problem.empty()) {
    answer.problem.insert(0, answer.prior ? "no rotation during the readout: " : "no rotation prior: ");
  }
  readout_ = query.readout;
  problem_ = answer.problem;
  return answer;
}

void RotationSource::compare(const RotationAnswer& answer, const RobustResult& seen) {
  const PriorQuery& query = answer.query;
  const Eigen::Vector3d visual = rotationVector(seen.judgement.pose.R);
  const Eigen::Matrix3d covariance = seen.judgement.pose.covariance.bottomRightCorner<3, 3>();
  const auto sensor = [&](double from, double to) { return measure({query.camera_frame, from, to}).prior; };
  std::lock_guard<std::mutex> lock(mutex_);
  calibration_.add({query.from, query.to, visual, covariance}, sensor);
  pairs_by_rates_ += seen.row_correction == RowCorrection::kPrior;
  comparison_.add({query.from, query.to, visual, rotationVector(answer.prior->R),
                   calibration_.dispersion() * (covariance + answer.prior->covariance)});
}

PriorReport RotationSource::report() {
  std::lock_guard<std::mutex> lock(mutex_);
  PriorReport report;
  report.summary = comparison_.doubt();
  if (report.summary.empty()) report.summary = problem_;
  report.doubtful = !report.summary.empty();
  if (!report.doubtful) report.summary = comparison_.agreement();
  report.found = calibration_.found(name_, image_time_offset_);
  report.values = calibration_.values(image_time_offset_);
  const auto add = [&](const char* key, const std::string& value) { report.values.emplace_back(key, value); };
  add("pairs compared", std::to_string(comparison_.pairs()));
  if (readout_ > 0) add("pairs corrected for readout", std::to_string(pairs_by_rates_));
  add("contradicting", std::to_string(std::lround(100 * comparison_.contradicting())) + " %");
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
