#include "trust/match_label.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace gms_ransac {

namespace {

constexpr double kDeviations = 2;                         // of the truth's noise that a label allows for
constexpr int kReach = static_cast<int>(kCorrectWithin);  // of surfaces about a keypoint, pixels
constexpr double kNearest = 1;  // metres: what stands nearer to a camera that stands still is rare

/// Standard deviation along the worst axis.
double worst(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

}  // namespace

MatchLabel::MatchLabel(const PairTruth& truth, const Camera& camera, const TruthNoise& noise, const ClockStep& step)
    : truth_(truth), camera_(camera) {
  if (!truth.currentInReference()) return;
  baseline_ = truth.currentInReference()->translation().norm();
  moved_ = hasMoved(baseline_, noise);
  const PairNoise of_pair(noise, step, *truth.currentInReference());
  rotation_sigma_ = worst(of_pair.rotation);
  translation_sigma_ = worst(of_pair.translation);
}

std::optional<bool> MatchLabel::within(double distance, double pose_noise_px) const {
  const double limit = std::hypot(kCorrectWithin, kDeviations * pose_noise_px);
  if (limit > kLoosestLabel) return std::nullopt;
  return distance < limit;
}

double MatchLabel::parallax(const cv::Point2f& reference, const cv::Point2f& current) const {
  const Eigen::Matrix3d K = camera_.K();
  const Eigen::Matrix3d R = truth_.currentInReference()->linear().transpose();
  const Eigen::Vector3d turned = K * R * K.inverse() * homogeneous(camera_.undistort(reference));
  if (turned.z() <= 0) return kLoosestLabel;
  return (turned - turned.z() * homogeneous(camera_.undistort(current))).head<2>().norm() / turned.z();
}

std::optional<bool> MatchLabel::operator()(const cv::Point2f& reference, const cv::Point2f& current) const {
  const bool posed = truth_.currentInReference().has_value() && camera_.calibrated();
  const double rotation_px = posed ? rotation_sigma_ * camera_.meanFocalLength() : 0;
  if (truth_.hasTransfer()) {
    const std::optional<double> distance = truth_.transferDistance(reference, current, kReach);
    if (distance) return within(*distance, rotation_px);
  }
  if (!truth_.hasEpipolar()) return std::nullopt;
  if (!posed) return within(truth_.epipolarDistance(reference, current), 0);
  if (!moved_) {
    const double translation_px = (baseline_ + translation_sigma_) / kNearest * camera_.meanFocalLength();
    return within(parallax(reference, current), std::hypot(rotation_px, translation_px));
  }
  const double direction_px = translation_sigma_ / baseline_ * parallax(reference, current);
  return within(truth_.epipolarDistance(reference, current), std::hypot(rotation_px, direction_px));
}

}  // namespace gms_ransac
