#include "robust/acceptance.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace gms_ransac {

namespace {

/// Survivors of the filter come in groups that move alike, so a cell of the motion-statistics grid counts once however
/// many inliers it holds. As many cells as the sample has points, but no more than the five degrees of freedom of a
/// relative pose, determine the model; two more must check it. The 41 of 57 poses of tum_fr3_cabinet from fewer cells
/// were all more than 15 degrees wrong (doc/estimator.md).
int minimumCells(int sample_size) {
  constexpr int kPoseFreedoms = 5;
  constexpr int kCheckingCells = 2;
  return std::min(sample_size, kPoseFreedoms) + kCheckingCells;
}

int cellsWithInliers(const PointPairs& pairs, const std::vector<uint8_t>& inlier, std::vector<uint8_t>& seen) {
  seen.clear();
  int count = 0;
  for (size_t i = 0; i < inlier.size(); ++i) {
    if (!inlier[i]) continue;
    const auto cell = static_cast<size_t>(pairs.cell[i]);
    if (cell >= seen.size()) seen.resize(cell + 1, 0);
    count += !seen[cell];
    seen[cell] = 1;
  }
  return count;
}

/// True when the inliers of one image lie on a line (or in a point) up to the threshold: such matches fit a whole
/// family of models, and the one found means nothing.
bool collinear(const std::vector<float>& x, const std::vector<float>& y, const std::vector<uint8_t>& inlier,
               double threshold_px) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double n = 0;
  for (size_t i = 0; i < inlier.size(); ++i) {
    if (!inlier[i]) continue;
    sum += Eigen::Vector2d(x[i], y[i]);
    ++n;
  }
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (size_t i = 0; i < inlier.size(); ++i) {
    if (!inlier[i]) continue;
    const Eigen::Vector2d d = Eigen::Vector2d(x[i], y[i]) - sum / n;
    scatter += d * d.transpose();
  }
  const double half_trace = 0.5 * scatter.trace();
  const double smaller = half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - scatter.determinant()));
  return smaller < n * threshold_px * threshold_px;
}

}  // namespace

bool Acceptance::accepts(const PointPairs& pairs, int sample_size, double threshold_px, const RobustResult& result,
                         const std::vector<int>* order) {
  chance_.setSampleSize(sample_size);
  bool supported = result.inlier_count >= chance_.minimum(pairs.size());
  if (order != nullptr) {
    for (int length = pairs.size() / 2, halvings = 0; halvings < 3 && !supported; length /= 2, ++halvings) {
      int inliers = 0;
      for (int k = 0; k < length; ++k) inliers += result.inlier[static_cast<size_t>((*order)[static_cast<size_t>(k)])];
      supported = inliers >= chance_.minimum(length);
    }
  }
  return supported && cellsWithInliers(pairs, result.inlier, seen_cells_) >= minimumCells(sample_size) &&
         !collinear(pairs.x_reference, pairs.y_reference, result.inlier, threshold_px) &&
         !collinear(pairs.x_current, pairs.y_current, result.inlier, threshold_px);
}

}  // namespace gms_ransac
