#include "judgement/rival_motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// Measured in doc/estimator.md.
constexpr double kLeastAdvantage = 0.75;             ///< standard deviations
constexpr double kLeastAdvantageOnPlane = 2.5;       ///< likewise
constexpr double kOtherDirection = 20 * M_PI / 180;  ///< below it is the same valley
constexpr Loss kRivalLoss = {4, 1};
// A few steps on a part of the matches show which are hopeless: so many standard deviations behind.
constexpr int kFirstMatches = 256;
constexpr int kFirstIterations = 2, kFurtherIterations = 5;
constexpr double kHopeless = 3;

/// By how many standard deviations the first residuals explain the matches better than the second.
double advantage(const std::vector<float>& first, const std::vector<float>& second, int count,
                 const std::vector<int32_t>& cells, std::vector<double>& by_cell) {
  by_cell.clear();
  double sum = 0, squares = 0;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const auto cell = static_cast<size_t>(cells[i]);
    if (cell >= by_cell.size()) by_cell.resize(cell + 1, 0.0);
    const double difference = std::min(second[i], 1.f) - std::min(first[i], 1.f);
    by_cell[cell] += difference;
    sum += difference;
  }
  for (double difference : by_cell) squares += difference * difference;
  return squares > 0 ? sum / std::sqrt(squares) : 0;
}

}  // namespace

bool findRival(const ResidualKernels& kernels, const PointColumnsView& points, const TwoViewPose& pose,
               const std::vector<float>& residuals, const std::vector<OtherMotion>& others,
               const std::vector<int32_t>& cells, RivalBuffers& work, double& rotation_spread, int64_t& evaluations) {
  rotation_spread = 0;
  bool found = false;
  const auto same_valley = [&](const TwoViewPose& other) {
    return std::abs(other.t.dot(pose.t)) > std::cos(kOtherDirection);
  };
  // Refines a rival on some of the matches; false if the pose beats it there by more than `most` or it came to be much
  // the same motion.
  const auto standsUp = [&](const PointColumnsView& part, int iterations, double most, TwoViewPose& rival) {
    const PoseModel model(kernels, part);
    evaluations += static_cast<int64_t>(part.count) * (model.refine(kRivalLoss, iterations, rival) + 1);
    if (same_valley(rival)) return false;
    model.residualsInFront(rival, work.rival.data());
    return advantage(residuals, work.rival, part.count, cells, work.by_cell) < most;
  };
  for (const OtherMotion& other : others) {
    const double least_advantage = other.of_plane ? kLeastAdvantageOnPlane : kLeastAdvantage;
    TwoViewPose rival = other.pose;
    if (same_valley(rival) || !standsUp(firstColumns(points, kFirstMatches), kFirstIterations, kHopeless, rival) ||
        !standsUp(points, kFurtherIterations, least_advantage, rival)) {
      continue;
    }
    const double spread = Eigen::AngleAxisd(Eigen::Matrix3d(rival.R.transpose() * pose.R)).angle();
    rotation_spread = std::max(rotation_spread, spread);
    found = true;
  }
  return found;
}

}  // namespace gms_ransac
