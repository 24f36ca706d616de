#include "judgement/alternative_motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// What the statistic of Vuong's test must reach for the pose to count as better; measured in doc/estimator.md.
constexpr double kLeastVuong = 0.75;
constexpr double kLeastVuongOnPlane = 2.5;
constexpr double kOtherDirection = 20 * M_PI / 180;  ///< closer ones are the same local minimum
constexpr Loss kAlternativeLoss = {4, 1};
// A few steps on a part of the matches show which cannot come near: those that lose by so much there.
constexpr int kFirstMatches = 256;
constexpr int kFirstIterations = 2, kFurtherIterations = 5;
constexpr double kDropBeyond = 3;

/// The statistic of Vuong's test of non-nested models (Econometrica 1989) for the first residuals against the second:
/// the sum of the differences of truncated costs over the root of the sum of their squares, not centred, each cell one
/// observation. At most the root of the number of cells.
double vuongStatistic(const std::vector<float>& first, const std::vector<float>& second, int count,
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

bool findAlternativeMotion(const ResidualKernels& kernels, const PointColumnsView& points, const TwoViewPose& pose,
                           const std::vector<float>& residuals, const std::vector<AlternativeMotion>& alternatives,
                           const std::vector<int32_t>& cells, AlternativeBuffers& work, double& rotation_spread,
                           int64_t& evaluations) {
  rotation_spread = 0;
  bool found = false;
  const auto same_direction = [&](const TwoViewPose& other) {
    return std::abs(other.t.dot(pose.t)) > std::cos(kOtherDirection);
  };
  // Refines an alternative on some of the matches; false where Vuong's statistic of the pose against it reaches `most`,
  // or it came to be much the same motion.
  const auto isNoWorse = [&](const PointColumnsView& part, int iterations, double most, TwoViewPose& alternative) {
    const PoseModel model(kernels, part);
    evaluations += static_cast<int64_t>(part.count) * (model.refine(kAlternativeLoss, iterations, alternative) + 1);
    if (same_direction(alternative)) return false;
    model.residualsInFront(alternative, work.residuals.data());
    return vuongStatistic(residuals, work.residuals, part.count, cells, work.by_cell) < most;
  };
  for (const AlternativeMotion& candidate : alternatives) {
    const double least = candidate.of_plane ? kLeastVuongOnPlane : kLeastVuong;
    TwoViewPose alternative = candidate.pose;
    if (same_direction(alternative) ||
        !isNoWorse(firstColumns(points, kFirstMatches), kFirstIterations, kDropBeyond, alternative) ||
        !isNoWorse(points, kFurtherIterations, least, alternative)) {
      continue;
    }
    const double spread = Eigen::AngleAxisd(Eigen::Matrix3d(alternative.R.transpose() * pose.R)).angle();
    rotation_spread = std::max(rotation_spread, spread);
    found = true;
  }
  return found;
}

}  // namespace gms_ransac
