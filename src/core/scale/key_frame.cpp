#include "scale/key_frame.h"

#include <algorithm>

#include <Eigen/LU>

#include "matching/aligned_points.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// The key frame is the reference of this pair as soon as fewer of its points are seen: as a share, and a number. Where
// a rolling shutter may bend the images, they differ the more the longer it is kept.
constexpr double kStillSeen = 0.15, kStillSeenRolling = 0.33;
constexpr double kLeastStillSeen = 30;

/// The motion by two measurements of it whose errors may be correlated in any way (covariance intersection with equal
/// weights, Julier & Uhlmann 1997): the pairs between the key frame and this image saw the same points.
RelativePose fused(const RelativePose& a, const RelativePose& b) {
  const Matrix6d gain = a.covariance * (a.covariance + b.covariance).inverse();
  Vector6d difference;
  difference << b.t - a.t, rotationVector(b.R * a.R.transpose());
  const Vector6d step = gain * difference;
  RelativePose both = a;
  both.t += step.head<3>();
  both.R = rotationFromVector(step.tail<3>()) * a.R;
  both.covariance = 2 * (a.covariance - gain * a.covariance);
  return both;
}

}  // namespace

std::optional<SensorEvidence> KeyFrame::locate(const DepthPair& pair, const PairReader& reader,
                                               const PairPoints& of_pair, const SensorPrior& prior,
                                               const JointEstimate& motion) {
  const RelativePose chain = chained(reference, motion.pose);
  std::vector<JointPoint> still_seen = stillSeen(pair, reader, of_pair, chain);
  const auto count = static_cast<double>(still_seen.size());
  const double share = pair.mayRoll() ? kStillSeenRolling : kStillSeen;
  std::optional<JointEstimate> direct;
  if (count >= std::max(kLeastStillSeen, share * static_cast<double>(points.size())))
    direct = refineJointly(still_seen, {chain, pair.baseline > 0}, prior, true);
  if (!direct) {
    std::optional<SensorEvidence> told = sensor;
    begin(pair, of_pair, motion);
    return told;
  }
  current = fused(chain, direct->pose);
  sensor = direct->sensor;
  is_reference = false;
  return std::nullopt;
}

std::vector<JointPoint> KeyFrame::stillSeen(const DepthPair& pair, const PairReader& reader, const PairPoints& of_pair,
                                            const RelativePose& chain) {
  const auto earlier = [](const Point& point, uint32_t track) { return point.track < track; };
  std::vector<JointPoint> still_seen;
  for (size_t i = 0; i < of_pair.joint.size(); ++i) {
    const Sighting& sighting = of_pair.sightings[i];
    const auto point = std::lower_bound(points.begin(), points.end(), sighting.track, earlier);
    if (point == points.end() || point->track != sighting.track) continue;
    JointPoint joint = of_pair.joint[i];
    if (!image.empty() && !pair.current_image.empty()) {
      PointToAlign place = {point->pixel, sighting.current};
      place.guess.shape *= point->shape;
      const auto found = align(image, pair.current_image, place, kInLaterImage);
      if (!found) continue;
      point->shape = found->shape;
      joint.current = reader.aligned(*found, reader.currentDepth(sighting.point));
    }
    joint.reference = point->seen;
    joint.begin(chain, depthIn(reference, of_pair.joint[i].reference.value));
    still_seen.push_back(joint);
  }
  return still_seen;
}

void KeyFrame::begin(const DepthPair& pair, const PairPoints& of_pair, const JointEstimate& motion) {
  *this = KeyFrame();
  current = motion.pose;
  sensor = motion.sensor;
  if (pair.hasPixels()) image = pair.reference_image.clone();
  for (size_t i = 0; i < of_pair.joint.size(); ++i) {
    const Sighting& sighting = of_pair.sightings[i];
    if (sighting.track == 0 || sighting.aligned == image.empty()) continue;
    points.push_back({sighting.track, of_pair.joint[i].reference, sighting.pixel, sighting.current.shape});
  }
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.track < b.track; });
}

}  // namespace gms_ransac
