#include "judgement/rotation_rivals.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "judgement/lanes.h"
#include "judgement/vuong.h"

namespace gms_ransac {

namespace {

// Of Vuong's statistics, in standard deviations: what a translation needs.
constexpr double kLeastAgainstRotation = 2.5;
constexpr double kLeastAgainstRows = 0;
/// Below these a turn explains the matches so much better that it is the answer.
constexpr double kRotationExplainsBetter = 0, kRowsExplainBetter = -2;
/// Of the inliers, without parallax. Where more are still, a body that moves by itself may be all that moves
/// (doc/uncertainty.md).
constexpr double kMostStill = 0.45;
/// The same of those that the pose itself puts at infinity, where noise alone decides on which side of it they lie.
/// Nearly all views of which two fifths are background show less, and real ones with more are wrong no more often
/// (doc/trust.md).
constexpr double kMostAtInfinity = 0.4;

// Costs are squared standard deviations. A pose gives each match a depth of its own, and that freedom costs it log r
// for coordinates of dimension r = 4 (Torr 1998, lambda_1). A wrong match costs no more than three deviations.
constexpr float kFreedomOfDepth = 1.3863f;
constexpr float kMostCost = 9;
constexpr float kInlierCost = 9;
// Parallax along the epipolar line, squared standard deviations: what noise mostly stays below, and hardly goes beyond.
constexpr float kNear = 1.5f * 1.5f, kFurther = 3.5f * 3.5f;

/// Softness of the loss of each iteration, squared standard deviations: near points of a translating camera drop out.
constexpr float kRowSoftness[] = {100, 100, 30, 30, 9};

constexpr int kFittedMatches = 256;  ///< a random part
constexpr float kTiny = 1e-18f;      ///< keeps points on the line at infinity finite

/// A turn, its rate by the row of the reference image, and that by how far the match moves over the rows (instead of
/// by the row of the current image, which is nearly the same); radians.
using RowTurn = Eigen::Matrix3f;

/// What a turn leaves of matches.
struct TurnedMatches {
  VectorLanes flow_x, flow_y;  ///< derivative of the place by a small turn
  Lanes x, y;                  ///< the place after the turn
  Lanes dx, dy;                ///< displacement from there
  Lanes row, rows_moved, weight;

  TurnedMatches(const PointColumnsView& points, int i, const Eigen::Matrix3f& R) {
    const VectorLanes turned = R * VectorLanes(points.x1 + i, points.y1 + i);
    const Lanes inverse_z = turned.z / (turned.z * turned.z + kTiny);
    x = turned.x * inverse_z;
    y = turned.y * inverse_z;
    const Lanes xy = x * y;
    flow_x = {-xy, 1 + x * x, -y};
    flow_y = {-(1 + y * y), xy, x};
    dx = lanes(points.x2 + i) - x;
    dy = lanes(points.y2 + i) - y;
    row = lanes(points.y1 + i);
    rows_moved = lanes(points.y2 + i) - row;
    weight = lanes(points.weight + i);
  }

  /// Squared deviations from the turn with rows.
  Lanes cost(const RowTurn& turn, float inverse_variance) const {
    const VectorLanes at_row(turn(0, 0) + row * turn(0, 1) + rows_moved * turn(0, 2),
                             turn(1, 0) + row * turn(1, 1) + rows_moved * turn(1, 2),
                             turn(2, 0) + row * turn(2, 1) + rows_moved * turn(2, 2));
    const Lanes rx = dx - dot(flow_x, at_row), ry = dy - dot(flow_y, at_row);
    return 0.5f * inverse_variance * weight * (rx * rx + ry * ry);
  }
};

/// Normal equations of the turn with rows. The derivative of a match by its parameters is (1, row, rows_moved) times
/// its flow, so that the matrix is that of (1, row, rows_moved) with blocks of the flow's for entries.
class RowEquations {
 public:
  RowEquations() {
    for (auto& block : blocks_) std::fill(std::begin(block), std::end(block), Lanes::Zero());
    for (auto& part : gradient_) std::fill(std::begin(part), std::end(part), Lanes::Zero());
  }

  void add(const TurnedMatches& m, const Lanes& weight) {
    const VectorLanes x = weight * m.flow_x, y = weight * m.flow_y;
    const Lanes flow[] = {x.x * m.flow_x.x + y.x * m.flow_y.x, x.x * m.flow_x.y + y.x * m.flow_y.y,
                          x.x * m.flow_x.z + y.x * m.flow_y.z, x.y * m.flow_x.y + y.y * m.flow_y.y,
                          x.y * m.flow_x.z + y.y * m.flow_y.z, x.z * m.flow_x.z + y.z * m.flow_y.z};
    const Lanes along[] = {x.x * m.dx + y.x * m.dy, x.y * m.dx + y.y * m.dy, x.z * m.dx + y.z * m.dy};
    const Lanes rows[] = {
        Lanes::Ones(), m.row, m.rows_moved, m.row * m.row, m.row * m.rows_moved, m.rows_moved * m.rows_moved};
    for (int b = 0; b < 6; ++b) {
      for (int k = 0; k < 6; ++k) blocks_[b][k] += rows[b] * flow[k];
    }
    for (int b = 0; b < 3; ++b) {
      for (int k = 0; k < 3; ++k) gradient_[b][k] += rows[b] * along[k];
    }
  }

  RowTurn solve() const {
    // Upper triangles by rows.
    constexpr int kPlace[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    Eigen::Matrix<double, 9, 9> A;
    Eigen::Matrix<double, 9, 1> b;
    for (int i = 0; i < 9; ++i) {
      for (int j = 0; j < 9; ++j) {
        A(i, j) = static_cast<double>(blocks_[kPlace[i / 3][j / 3]][kPlace[i % 3][j % 3]].sum());
      }
      b[i] = static_cast<double>(gradient_[i / 3][i % 3].sum());
      A(i, i) += 1e-9;
    }
    const Eigen::Matrix<double, 9, 1> turn = A.ldlt().solve(b);
    return Eigen::Map<const Eigen::Matrix3d>(turn.data()).cast<float>();
  }

 private:
  Lanes blocks_[6][6], gradient_[3][3];
};

/// How many matches have no parallax, by how many have less than 1.5 deviations of it along their epipolar lines, and
/// how many between that and 3.5. Noise alone puts 86.6 and 13.3 % there; parallaxes that are spread over more than the
/// noise put them there as the widths of the two, 1.5 to 2.
double stillMatches(int near, int further) {
  constexpr double kNoiseNear = 0.866, kNoiseFurther = 0.133, kSpread = 1.5 / 2;
  return std::max(0.0, (near - kSpread * further) / (kNoiseNear - kSpread * kNoiseFurther));
}

/// How many of the inliers a pose moves against its translation, by noise and not by more: half of those at infinity.
int movedBackwards(const PointColumnsView& points, const TwoViewPose& pose, const std::vector<float>& residuals,
                   float variance) {
  const auto R = pose.R.cast<float>().eval();
  const Eigen::Vector3f t = pose.t.cast<float>();
  int count = 0;
  for (int i = 0; i < points.size; i += kLanesAtOnce) {
    const TurnedMatches match(points, i, R);
    // The way of a point that comes from infinity, times a depth.
    const Lanes way_x = t.x() - match.x * t.z(), way_y = t.y() - match.y * t.z();
    const Lanes along = match.weight * (match.dx * way_x + match.dy * way_y);  // padding has no weight
    // A displacement has the noise of both images.
    const Lanes farthest = 2 * kFurther * variance * match.weight * (way_x * way_x + way_y * way_y);
    count += static_cast<int>(
        (along < 0 && along * along < farthest && lanes(residuals.data() + i) < kInlierCost * variance).count());
  }
  return count;
}

}  // namespace

DirectionDoubt RotationVerdict::doubt() const {
  if (against_rotation < kLeastAgainstRotation || against_rows < kLeastAgainstRows) return DirectionDoubt::kTurn;
  if (still > kMostStill || at_infinity > kMostAtInfinity) return DirectionDoubt::kStill;
  return DirectionDoubt::kNone;
}

BelievedRotation RotationVerdict::believed() const {
  if (against_rotation < kRotationExplainsBetter || against_rows < kRowsExplainBetter) return BelievedRotation::kOfTurn;
  return against_rotation < kLeastAgainstRotation ? BelievedRotation::kOfEither : BelievedRotation::kOfPose;
}

bool RotationVerdict::onlyTurned() const { return still > kMostStill || against_rotation < kRotationExplainsBetter; }

RotationVerdict RotationRivals::compare(const JudgedPose& judged, const Eigen::Matrix3d& R,
                                        const std::vector<float>& rotation_residuals) {
  const PointColumnsView points = judged.points.view();
  const MatchNoise& noise = judged.noise;
  const double variance = noise.sigma() * noise.sigma();
  const auto per_variance = static_cast<float>(1 / variance);
  const auto count = static_cast<size_t>(points.count);
  pose_costs_.resize(count);
  costs_.resize(count);
  int inliers = 0, near = 0, further = 0;
  for (size_t i = 0; i < count; ++i) {
    const float e = noise.residuals()[i] * per_variance;
    pose_costs_[i] = std::min(e, kMostCost) + kFreedomOfDepth;
    // A transfer distance has the noise of both images.
    costs_[i] = std::min(0.5f * rotation_residuals[i] * per_variance, kMostCost + kFreedomOfDepth);
    if (!(e < kInlierCost)) continue;
    ++inliers;
    // Squared, without the part across the epipolar line.
    const float along = 0.5f * rotation_residuals[i] * per_variance - e;
    near += along < kNear;
    further += along >= kNear && along < kFurther;
  }
  RotationVerdict verdict;
  if (inliers > 0) {
    verdict.still = stillMatches(near, further) / inliers;
    verdict.at_infinity =
        2. * movedBackwards(points, judged.pose, noise.residuals(), static_cast<float>(variance)) / inliers;
  }
  verdict.against_rotation = vuong(judged.points.cells());
  fitRows(points, R, variance);
  verdict.against_rows = vuong(judged.points.cells());
  return verdict;
}

void RotationRivals::fitRows(const PointColumnsView& points, const Eigen::Matrix3d& R, double variance) {
  const auto turned_by = R.cast<float>().eval();
  const auto inverse_variance = static_cast<float>(1 / variance);
  const PointColumnsView part = firstColumns(points, kFittedMatches);
  RowTurn turn = RowTurn::Zero();
  for (const float softness : kRowSoftness) {
    RowEquations equations;
    for (int i = 0; i < part.size; i += kLanesAtOnce) {
      const TurnedMatches matches(part, i, turned_by);
      const Lanes falloff = (1 + matches.cost(turn, inverse_variance) / softness).inverse();
      equations.add(matches, matches.weight * falloff * falloff);
    }
    turn = equations.solve();
  }
  costs_.resize(static_cast<size_t>(points.size));
  for (int i = 0; i < points.size; i += kLanesAtOnce) {
    const Lanes cost = TurnedMatches(points, i, turned_by).cost(turn, inverse_variance);
    lanes(costs_.data() + i) = cost.min(kMostCost + kFreedomOfDepth);
  }
  costs_.resize(static_cast<size_t>(points.count));
}

double RotationRivals::vuong(const std::vector<int32_t>& cells) {
  return vuongStatistic(static_cast<int>(costs_.size()), cells, by_cell_,
                        [&](size_t i) { return costs_[i] - pose_costs_[i]; });
}

}  // namespace gms_ransac
