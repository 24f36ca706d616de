#include "priors/wheel_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/core.hpp>

#include "quantiles.h"

namespace gms_ransac {

namespace {

/// Parallax below so many standard deviations of a keypoint is noise.
constexpr double kNoiseSigmas = 2;

}  // namespace

std::string WheelCheck::judge(const Eigen::Vector3d& travelled, const RobustResult& seen) {
  const double length = travelled.norm(), parallax = seen.judgement.median_parallax_px;
  if (seen.judgement.translation_observable && length < kStanding) {
    return cv::format(
        "by the odometry the camera stood (%.4f m), by the images it moved (%.1f px of parallax): the "
        "wheels slip, or the odometry is late",
        length, parallax);
  }
  const std::vector<double> usual(usual_.begin(), usual_.end());
  const double expected = usual.size() < kFewest ? 0 : length * quantilesOf(usual).median;  // 0: not known
  const double noise = kNoiseSigmas * seen.judgement.sigma_px;
  const bool too_little = expected > kSlip * std::max(parallax, noise);
  const bool too_much = expected > 0 && parallax > kSlip * std::max(expected, noise);
  // A view whose depth changed for good, as behind a door, becomes what is usual.
  if (length >= kStanding) usual_.push_back(parallax / length);
  if (usual_.size() > kPairs) usual_.pop_front();
  if (too_little || too_much) {
    return cv::format(
        "by the odometry the camera moved %.3f m, which usually gives %.1f px of parallax, but the "
        "images have %.1f px: the wheels slip",
        length, expected, parallax);
  }
  const double cosine = travelled.dot(seen.judgement.pose.t) / (length * seen.judgement.pose.t.norm());
  if (!seen.judgement.translation_observable || !(cosine < kOtherWay)) return std::string();
  return cv::format(
      "the camera's direction by the odometry is %.0f degrees from that by the images: correct the tf "
      "from the body of the odometry to the camera",
      std::acos(std::max(cosine, -1.0)) * 180 / CV_PI);
}

}  // namespace gms_ransac
