#include "past/votes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "gms_ransac/point_pairs.h"
#include "past/pixel_motion.h"

namespace gms_ransac {

namespace {

/// A match whose next nearest descriptor is further by this factor is distinctive (Lowe 2004).
constexpr float kDistinctiveRatio = 0.8f;
/// A point agrees with a rotation up to this distance from its place, pixels.
constexpr double kFromPoint = 12;
constexpr int kFewestVoting = 5;     ///< that vote; fewer say nothing
constexpr int kKeypointsOfCell = 3;  ///< so many should be found again somewhere in their cell

struct VotingCell {
  int matches = 0, on_line = 0, at_point = 0;
  int keypoints = 0, inliers = 0;
};

}  // namespace

void Votes::collect(const Features& reference, const Features& current, const Camera& camera, MatchResult& result) {
  Judgement& judgement = result.robust.judgement;
  if (!judgement.pose_found) return;
  const PixelMotion motion(camera, judgement.motion), rotation(camera, judgement.rotation);
  // Only one of the matches that share a current point can be right: the closest one votes.
  closest_.assign(current.keypoints.size(), std::numeric_limits<int32_t>::max());
  for (const Match& match : result.raw) {
    int32_t& distance = closest_[static_cast<size_t>(match.current)];
    distance = std::min<int32_t>(distance, match.distance);
  }
  std::array<VotingCell, kSpreadGridSide * kSpreadGridSide> cells;
  const auto cellOf = [&](const cv::Point2f& pixel) -> VotingCell& {
    return cells[static_cast<size_t>(spreadCell(pixel, reference.image_size))];
  };
  result.forEachRaw([&](const Match& match, MatchStage stage, size_t row) {
    const cv::Point2f& pixel = reference.keypoints[static_cast<size_t>(match.reference)].pt;
    VotingCell& cell = cellOf(pixel);
    cell.inliers += stage != MatchStage::kRaw && result.robust.inlier[row] != 0;
    if (static_cast<float>(match.distance) >= kDistinctiveRatio * static_cast<float>(match.second_distance)) return;
    if (match.distance > closest_[static_cast<size_t>(match.current)]) return;
    const cv::Point2f p = camera.undistort(pixel);
    const cv::Point2f q = camera.undistort(current.keypoints[static_cast<size_t>(match.current)].pt);
    ++cell.matches;
    cell.on_line += motion.fromLine(p, q) < kOnLine;
    cell.at_point += (rotation.toReference(q) - Eigen::Vector2d(p.x, p.y)).norm() < kFromPoint;
  });
  for (const cv::KeyPoint& keypoint : reference.keypoints) {
    VotingCell& cell = cellOf(keypoint.pt);
    if (cell.keypoints >= kKeypointsOfCell || result.mask.covers(keypoint.pt)) continue;
    const Eigen::Vector2d q = motion.toCurrent(camera.undistort(keypoint.pt));
    const bool in_view =
        q.x() >= 0 && q.y() >= 0 && q.x() < current.image_size.width && q.y() < current.image_size.height;
    cell.keypoints += in_view;
  }
  int voting = 0, of_pose = 0, of_rotation = 0, full = 0, seen = 0;
  for (const VotingCell& cell : cells) {
    voting += cell.matches > 0;
    of_pose += 2 * cell.on_line > cell.matches;
    of_rotation += 2 * cell.at_point > cell.matches;
    full += cell.keypoints >= kKeypointsOfCell;
    seen += cell.keypoints >= kKeypointsOfCell && cell.inliers > 0;
  }
  if (voting >= kFewestVoting) {
    judgement.evidence[Evidence::kVotes] = static_cast<double>(of_pose) / voting;
    judgement.evidence[Evidence::kRotationVotes] = static_cast<double>(std::max(of_pose, of_rotation)) / voting;
  }
  if (full >= kFewestVoting) judgement.evidence[Evidence::kSeen] = static_cast<double>(seen) / full;
}

}  // namespace gms_ransac
