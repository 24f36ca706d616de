#include "past/standstill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace gms_ransac {

namespace {

constexpr double kShareAtRest = 0.9;  ///< of the cells at rest
constexpr int kFewestCells = 15;
/// At rest most keypoints are found again (0.86 and more in daylight), so that fewer matches in place are something of
/// the camera's own: in the dark the pattern of its pixels.
constexpr double kShareFound = 0.6;

struct CellAtRest {
  int matches = 0, resting = 0;
  Eigen::Vector2d place = Eigen::Vector2d::Zero(), moved = Eigen::Vector2d::Zero();  ///< sums over those that rest

  void add(const Eigen::Vector2d& from, const Eigen::Vector2d& step) {
    ++matches;
    if (step.norm() > kMostMoved) return;
    ++resting;
    place += from;
    moved += step;
  }
};

bool isCopy(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return a.pt == b.pt && a.octave == b.octave && a.response == b.response && a.angle == b.angle;
}

}  // namespace

bool standsStill(const Features& reference, const Features& current, const MatchResult& result, const Past* past) {
  const PointPairs& pairs = result.pairs;
  const std::vector<Match>& matches = result.matches;
  const size_t found = matches.size() + result.masked.size();
  if (static_cast<double>(found) < kShareFound * std::min(reference.size(), current.size())) return false;
  const auto isTrack = [&](const Match& match) { return past != nullptr && past->isStatic(match.reference); };
  const bool by_tracks = std::count_if(matches.begin(), matches.end(), isTrack) >= kEnoughTracks;
  std::array<CellAtRest, kSpreadGridSide * kSpreadGridSide> grid;
  const Eigen::Vector2d half(0.5 * pairs.image_reference.width, 0.5 * pairs.image_reference.height);
  for (size_t row = 0; row < matches.size(); ++row) {
    const Match& match = matches[row];
    if (by_tracks && !isTrack(match)) continue;
    if (match.distance == 0 && isCopy(reference.keypoints[match.reference], current.keypoints[match.current])) continue;
    const cv::Point2f from(pairs.x_reference[row], pairs.y_reference[row]);
    const auto cell = static_cast<size_t>(spreadCell(from, pairs.image_reference));
    grid[cell].add(Eigen::Vector2d(from.x, from.y) - half,
                   {pairs.x_current[row] - from.x, pairs.y_current[row] - from.y});
  }

  int cells = 0, resting = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double roll = 0, zoom = 0, spread = 0;
  for (const CellAtRest& cell : grid) {
    if (cell.matches == 0) continue;
    ++cells;
    if (2 * cell.resting < cell.matches) continue;
    ++resting;
    const Eigen::Vector2d place = cell.place / cell.resting, moved = cell.moved / cell.resting;
    shift += moved;
    roll += place.x() * moved.y() - place.y() * moved.x();
    zoom += place.dot(moved);
    spread += place.squaredNorm();
  }
  if (cells < kFewestCells || resting < kShareAtRest * cells || spread == 0) return false;
  // A slow motion moves all cells alike, by less than a point's noise.
  const double at_edge = half.norm() / spread;
  return shift.norm() < kMostDrift * resting && std::abs(roll) * at_edge < kMostDrift &&
         std::abs(zoom) * at_edge < kMostDrift;
}

}  // namespace gms_ransac
