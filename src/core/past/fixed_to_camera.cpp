#include "past/fixed_to_camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "past/standstill.h"
#include "support/order_statistics.h"

namespace gms_ransac {

namespace {

constexpr double kLeastFixed = 0.1;  ///< of the matches: fewer bend no answer
constexpr float kLeastMotion = 3;    ///< median displacement of the others, pixels: below it one motion explains both
constexpr double kMajority = 0.5, kLeastExplained = 0.3;
/// Share of the cells of static tracks that something else may account for.
constexpr double kFewOfTracks = 0.2;
/// A body that covers more of the cells is not told from a view.
constexpr double kMostOfBody = 0.3;
/// How far the votes of cells are believed, as those of alternative motions are (candidates.cpp).
constexpr double kVoteBelief = 12;
constexpr double kImprobable = 0.1;

float squaredDisplacement(const PointPairs& pairs, size_t row) {
  const float x = pairs.x_current[row] - pairs.x_reference[row], y = pairs.y_current[row] - pairs.y_reference[row];
  return x * x + y * y;
}

/// Matches of a part of the image.
struct Part {
  int fixed = 0, moving = 0;
};

/// Cells in which more matches stayed than moved, and the others.
template <size_t N>
Part countCells(const std::array<Part, N>& cells) {
  Part votes;
  for (const Part& cell : cells) {
    votes.fixed += cell.fixed > cell.moving;
    votes.moving += cell.moving > cell.fixed;
  }
  return votes;
}

}  // namespace

void FixedToCamera::resolve(Method& method, const Camera& camera, MatchResult& result, const Past* past) {
  others_move_ = false;
  // A few matches next to a mask, which it does not cover yet, bend a direction of little parallax.
  const double least = result.mask.empty() ? kLeastFixed * static_cast<double>(result.size()) : 0;
  if (!camera.calibrated() || !separate(result.pairs, least, past != nullptr)) return;
  others_.estimate(method, camera, result);
  RobustResult& robust = result.robust;
  others_move_ = explained() && !robust.judgement.translation_observable;
  const auto fewer = static_cast<double>(std::min(fixed_.size(), others_.rows.size()));
  if (fewer < least || !contradicts(camera, result.pairs)) return;
  const double rest = probabilityOfRest(result, past);
  others_move_ = rest >= kImprobable;
  if (rest < kImprobable) {
    others_.replace(camera, result);
    for (const int row : fixed_) robust.judgement.probability[static_cast<size_t>(row)] = 0;
  } else if (robust.judgement.pose_found) {
    for (RelativePose* pose : {&robust.judgement.motion, &robust.judgement.rotation}) {
      widen(Eigen::Matrix3d::Identity(), 1, *pose);
      widen(others_.robust.judgement.pose.R, 1 - rest, *pose);
    }
    robust.judgement.evidence[Evidence::kFixedToCamera] = 1 - rest;
  }
}

bool FixedToCamera::separate(const PointPairs& pairs, double least_fixed, bool few) {
  fixed_.clear();
  others_.rows.clear();
  const auto count = static_cast<size_t>(pairs.size());
  for (size_t row = 0; row < count; ++row) {
    const float noise = std::pow(pairs.scale_factor, static_cast<float>(pairs.octave_current[row]));
    const bool stayed = squaredDisplacement(pairs, row) <= kMostMoved * kMostMoved * noise;
    (stayed ? fixed_ : others_.rows).push_back(static_cast<int>(row));
  }
  const double least = std::max<double>(kMinimumMatches, least_fixed);
  const double least_others = few ? std::min<double>(least, kEnoughTracks) : least;
  if (static_cast<double>(fixed_.size()) < least || static_cast<double>(others_.rows.size()) < least_others)
    return false;
  squares_.clear();
  for (const int row : others_.rows) squares_.push_back(squaredDisplacement(pairs, static_cast<size_t>(row)));
  return nthSmallest(squares_, squares_.size() / 2) > kLeastMotion * kLeastMotion;
}

bool FixedToCamera::explained() const {
  const RobustResult& motion = others_.robust;
  const double least = std::max<double>(kMinimumMatches, kLeastExplained * static_cast<double>(others_.rows.size()));
  return motion.judgement.pose_found && motion.inlier_count >= least;
}

bool FixedToCamera::contradicts(const Camera& camera, const PointPairs& pairs) {
  if (!explained()) return false;
  const RobustResult& motion = others_.robust;
  const bool moves = motion.judgement.translation_observable;
  const std::vector<float>& residuals = others_.residuals(camera, pairs);
  const double f = camera.meanFocalLength();
  const double of_rotation = moves ? 0 : f * f * motion.judgement.pose.covariance.bottomRightCorner<3, 3>().trace();
  const auto excludes = [&](size_t row) {
    const double sigma = motion.judgement.sigma(pairs.octave_current[row], pairs.scale_factor);
    const double limit = kExplained * std::sqrt(1 + of_rotation / (2 * sigma * sigma));
    return residuals[row] > limit;
  };
  const auto excluded = std::count_if(fixed_.begin(), fixed_.end(), excludes);
  return static_cast<double>(excluded) > kMajority * static_cast<double>(fixed_.size());
}

double FixedToCamera::probabilityOfRest(const MatchResult& result, const Past* past) const {
  std::array<Part, kSpreadGridSide * kSpreadGridSide> cells, cells_of_tracks;
  int tracks = 0;
  const auto count = [&](size_t row, int Part::*kind) {
    const cv::Point2f place(result.pairs.x_reference[row], result.pairs.y_reference[row]);
    const auto cell = static_cast<size_t>(spreadCell(place, result.pairs.image_reference));
    ++(cells[cell].*kind);
    if (past == nullptr || !past->isStatic(result.matches[row].reference)) return;
    ++(cells_of_tracks[cell].*kind);
    ++tracks;
  };
  for (const int row : fixed_) count(row, &Part::fixed);
  for (size_t n = 0; n < others_.rows.size(); ++n) {
    if (others_.robust.inlier[n] != 0) count(others_.rows[n], &Part::moving);
  }
  const Part votes = countCells(cells), of_tracks = countCells(cells_of_tracks);
  if (tracks >= kEnoughTracks) {
    const bool small = votes.moving < kMostOfBody * (votes.fixed + votes.moving);
    if (small && of_tracks.moving < kFewOfTracks * (of_tracks.fixed + of_tracks.moving)) return 1;
    if (of_tracks.fixed < kFewOfTracks * (of_tracks.fixed + of_tracks.moving)) return 0;
  }
  const double z = (votes.fixed - votes.moving) / std::sqrt(std::max(1, votes.fixed + votes.moving));
  const double weight = std::exp(z * std::abs(z) / kVoteBelief);
  return weight / (1 + weight);
}

}  // namespace gms_ransac
