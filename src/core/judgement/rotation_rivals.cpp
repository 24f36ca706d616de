#include "judgement/rotation_rivals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

namespace {

// Costs are squared standard deviations. A pose gives each match a depth of its own, and that freedom costs it log r
// for coordinates of dimension r = 4 (Torr 1998, lambda_1). A wrong match costs no more than three deviations.
constexpr float kFreedomOfDepth = 1.3863f;
constexpr float kMostCost = 9;
constexpr float kInlierCost = 9;

/// Softness of the loss of each iteration, squared standard deviations: near points of a translating camera drop out.
constexpr double kRowSoftness[] = {100, 100, 30, 30, 9};

constexpr int kFittedMatches = 256;  ///< a random part

/// Derivative of a point's place by a small turn.
using Flow = Eigen::Matrix<double, 2, 3>;

/// What a turn leaves of a match.
struct TurnedMatch {
  Flow flow;
  Eigen::Vector2d displacement;

  TurnedMatch(const PointColumnsView& points, int i, const Eigen::Matrix3d& R) {
    const Eigen::Vector2d q = (R * Eigen::Vector3d(points.x1[i], points.y1[i], 1)).hnormalized();
    displacement = Eigen::Vector2d(points.x2[i], points.y2[i]) - q;
    flow << -q.x() * q.y(), 1 + q.x() * q.x(), -q.y(), -(1 + q.y() * q.y()), q.x() * q.y(), q.x();
  }
};

/// A turn, and its rates by the row of the reference and of the current image, radians.
using RowTurn = Eigen::Matrix<double, 3, 3>;

/// Squared deviations from the turn with rows.
double rowCost(const PointColumnsView& points, int i, const TurnedMatch& match, const RowTurn& turn, double variance) {
  const Eigen::Vector3d at_rows = turn.col(0) + points.y1[i] * turn.col(1) + points.y2[i] * turn.col(2);
  return points.weight[i] * (match.displacement - match.flow * at_rows).squaredNorm() / (2 * variance);
}

}  // namespace

RotationVerdict RotationRivals::compare(const PointColumnsView& points, const MatchNoise& noise,
                                        const Eigen::Matrix3d& R, const std::vector<float>& rotation_residuals,
                                        const std::vector<int32_t>& cells) {
  const double variance = noise.sigma() * noise.sigma();
  const auto per_variance = static_cast<float>(1 / variance);
  const auto count = static_cast<size_t>(points.count);
  pose_costs_.resize(count);
  costs_.resize(count);
  int inliers = 0, preferring = 0;
  for (size_t i = 0; i < count; ++i) {
    const float e = noise.residuals()[i] * per_variance;
    pose_costs_[i] = std::min(e, kMostCost) + kFreedomOfDepth;
    // A transfer distance has the noise of both images.
    costs_[i] = std::min(0.5f * rotation_residuals[i] * per_variance, kMostCost + kFreedomOfDepth);
    if (!(e < kInlierCost)) continue;
    ++inliers;
    preferring += costs_[i] > pose_costs_[i];
  }
  RotationVerdict verdict;
  verdict.share = inliers > 0 ? static_cast<double>(preferring) / inliers : 0;
  verdict.against_rotation = vuong(cells);
  fitRows(points, R, variance);
  verdict.against_rows = vuong(cells);
  return verdict;
}

void RotationRivals::fitRows(const PointColumnsView& points, const Eigen::Matrix3d& R, double variance) {
  RowTurn turn = RowTurn::Zero();
  const PointColumnsView part = firstColumns(points, kFittedMatches);
  for (const double softness : kRowSoftness) {
    Eigen::Matrix<double, 9, 9> A = 1e-9 * Eigen::Matrix<double, 9, 9>::Identity();
    Eigen::Matrix<double, 9, 1> b = Eigen::Matrix<double, 9, 1>::Zero();
    for (int i = 0; i < part.count; ++i) {
      const TurnedMatch match(part, i, R);
      const double falloff = 1 / (1 + rowCost(part, i, match, turn, variance) / softness);
      const double weight = part.weight[i] * falloff * falloff;
      // The row of a match is (1, y1, y2) times its flow, in blocks.
      const Eigen::Matrix3d squared = weight * match.flow.transpose().lazyProduct(match.flow);
      const Eigen::Vector3d along = weight * match.flow.transpose().lazyProduct(match.displacement);
      const double rows[] = {1, part.y1[i], part.y2[i]};
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l <= k; ++l) A.block<3, 3>(3 * k, 3 * l) += rows[k] * rows[l] * squared;
        b.segment<3>(3 * k) += rows[k] * along;
      }
    }
    Eigen::Map<Eigen::Matrix<double, 9, 1>>(turn.data()) = A.selfadjointView<Eigen::Lower>().ldlt().solve(b);
  }
  for (int i = 0; i < points.count; ++i) {
    const double cost = rowCost(points, i, TurnedMatch(points, i, R), turn, variance);
    costs_[static_cast<size_t>(i)] = std::min(static_cast<float>(cost), kMostCost + kFreedomOfDepth);
  }
}

double RotationRivals::vuong(const std::vector<int32_t>& cells) {
  by_cell_.assign(static_cast<size_t>(kSpreadGridSide) * kSpreadGridSide, 0.0);
  double sum = 0, squares = 0;
  for (size_t i = 0; i < costs_.size(); ++i) {
    const auto difference = static_cast<double>(costs_[i] - pose_costs_[i]);
    by_cell_[static_cast<size_t>(cells[i])] += difference;
    sum += difference;
  }
  for (const double difference : by_cell_) squares += difference * difference;
  return squares > 0 ? sum / std::sqrt(squares) : 0;
}

}  // namespace gms_ransac
