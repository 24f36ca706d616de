#include "robust/fast/rival_motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// Measured in doc/estimator.md.
constexpr double kLeastAdvantage = 0.75;             ///< standard deviations
constexpr double kOtherDirection = 20 * M_PI / 180;  ///< below it is the same valley
constexpr Loss kRivalLoss = {4, 1};
constexpr int kRivalIterations = 6;

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

bool findRival(const PoseModel& model, int match_count, const TwoViewPose& pose,
               const TwoViewPose (&starts)[kMaxMotionStarts], int start_count, const std::vector<int32_t>& cells,
               RivalBuffers& work, double& rotation_spread, int64_t& evaluations) {
  model.residuals(pose, work.own.data());
  rotation_spread = 0;
  bool found = false;
  // The Sampson distance does not tell t from -t.
  const auto same_valley = [&](const TwoViewPose& other) {
    return std::abs(other.t.dot(pose.t)) > std::cos(kOtherDirection);
  };
  for (int k = 0; k < start_count; ++k) {
    TwoViewPose rival = starts[k];
    if (same_valley(rival)) continue;
    evaluations += static_cast<int64_t>(match_count) * (model.refine(kRivalLoss, kRivalIterations, rival) + 1);
    if (same_valley(rival)) continue;
    model.residuals(rival, work.rival.data());
    if (advantage(work.own, work.rival, match_count, cells, work.by_cell) >= kLeastAdvantage) continue;
    const double spread = Eigen::AngleAxisd(Eigen::Matrix3d(rival.R.transpose() * pose.R)).angle();
    rotation_spread = std::max(rotation_spread, spread);
    found = true;
  }
  return found;
}

}  // namespace gms_ransac
