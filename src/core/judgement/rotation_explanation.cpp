#include "judgement/rotation_explanation.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "judgement/vuong.h"
#include "order_statistics.h"

namespace gms_ransac {

namespace {

/// Least Vuong statistic against a rotation for which a translation is needed, in standard deviations. Against
/// one with rolling shutter, which has six parameters more, it must be positive.
constexpr double kLeastAgainstRotation = 2.5;
/// Share of the inliers without parallax, beyond which a body that moves by itself may be all that moves.
constexpr double kMostStatic = 0.45;
/// The same of those that the pose itself puts at infinity. Views of which two fifths are background show less.
constexpr double kMostAtInfinity = 0.4;

// Costs are squared standard deviations. A pose gives each match a depth, which costs log 4 (Torr 1998, lambda_1 for
// coordinates of dimension 4). A wrong match costs no more than three deviations.
constexpr float kDepthCost = 1.3863f, kMostCost = 9, kMostRotationCost = kMostCost + kDepthCost;
// Squared parallax along the epipolar line: what noise mostly stays below, and hardly exceeds.
constexpr float kNear = 1.5f * 1.5f, kFurther = 3.5f * 3.5f;

/// Squared softness of the loss of each stage of the fits, in thresholds and in standard deviations: near points of a
/// translating camera drop out.
constexpr float kSoftness[] = {100, 10, 2}, kRollingSoftness[] = {100, 100, 30, 30, 9};
constexpr int kIterations = 3;
constexpr int kFittedMatches = 256;  ///< a random part
constexpr float kTiny = 1e-18f;      ///< keeps points on the line at infinity finite

/// The displacement of a match after a rotation.
struct RotatedMatch {
  float x, y;                  ///< the reference point's place after the rotation
  float dx, dy;                ///< displacement from there
  float flow_x[3], flow_y[3];  ///< derivative of the place by a small rotation
  float rows[3];               ///< 1, the row in the reference image, and by how much it differs in the current one
  float weight;

  RotatedMatch(const PointColumnsView& points, int i, const Eigen::Matrix3f& R) {
    const float x1 = points.x1[i], y1 = points.y1[i];
    const float z = R(2, 0) * x1 + R(2, 1) * y1 + R(2, 2), inverse_z = z / (z * z + kTiny);
    x = (R(0, 0) * x1 + R(0, 1) * y1 + R(0, 2)) * inverse_z;
    y = (R(1, 0) * x1 + R(1, 1) * y1 + R(1, 2)) * inverse_z;
    dx = points.x2[i] - x;
    dy = points.y2[i] - y;
    const float xy = x * y;
    flow_x[0] = -xy, flow_x[1] = 1 + x * x, flow_x[2] = -y;
    flow_y[0] = -(1 + y * y), flow_y[1] = xy, flow_y[2] = x;
    rows[0] = 1, rows[1] = y1, rows[2] = points.y2[i] - y1;
    weight = points.weight[i];
  }

  /// Squared deviations from the rotation whose rates by `rows` are the columns of `rates`, radians.
  float cost(const Eigen::Matrix3f& rates, float inverse_variance) const {
    float rx = dx, ry = dy;
    for (int k = 0; k < 3; ++k) {
      const float angle = rates(k, 0) * rows[0] + rates(k, 1) * rows[1] + rates(k, 2) * rows[2];
      rx -= flow_x[k] * angle;
      ry -= flow_y[k] * angle;
    }
    return 0.5f * inverse_variance * weight * (rx * rx + ry * ry);
  }
};

/// Normal equations of the rates. The derivative of a match is the outer product of its rows and its flow.
struct RollingEquations {
  double matrix[3][3][3][3] = {}, gradient[3][3] = {};  ///< by rows, then by axes

  void add(const RotatedMatch& match, float weight) {
    float flow[3][3], along[3];
    for (int k = 0; k < 3; ++k) {
      for (int m = 0; m < 3; ++m) {
        flow[k][m] = weight * (match.flow_x[k] * match.flow_x[m] + match.flow_y[k] * match.flow_y[m]);
      }
      along[k] = weight * (match.flow_x[k] * match.dx + match.flow_y[k] * match.dy);
    }
    for (int a = 0; a < 3; ++a) {
      for (int k = 0; k < 3; ++k) gradient[a][k] += static_cast<double>(match.rows[a] * along[k]);
      for (int b = 0; b <= a; ++b) {
        const float rows = match.rows[a] * match.rows[b];
        for (int k = 0; k < 3; ++k) {
          for (int m = 0; m < 3; ++m) matrix[a][b][k][m] += static_cast<double>(rows * flow[k][m]);
        }
      }
    }
  }

  Eigen::Matrix3f solve() const {
    Eigen::Matrix<double, 9, 9> A;
    Eigen::Matrix<double, 9, 1> b;
    for (int i = 0; i < 9; ++i) {
      for (int j = 0; j <= i; ++j) A(i, j) = A(j, i) = matrix[i / 3][j / 3][i % 3][j % 3];
      A(i, i) += 1e-9;
      b[i] = gradient[i / 3][i % 3];
    }
    const Eigen::Matrix<double, 9, 1> rates = A.llt().solve(b);
    return Eigen::Map<const Eigen::Matrix3d>(rates.data()).cast<float>();
  }
};

/// How many matches have no parallax, by how many have less than 1.5 deviations of it along their epipolar lines, and
/// how many between that and 3.5. Noise alone puts 86.6 and 13.3 % there; parallaxes that are spread over more than the
/// noise put them there as the widths of the two, 1.5 to 2.
double countStatic(int near, int further) {
  constexpr double kNoiseNear = 0.866, kNoiseFurther = 0.133, kSpread = 1.5 / 2;
  return std::max(0.0, (near - kSpread * further) / (kNoiseNear - kSpread * kNoiseFurther));
}

/// How many of the inliers a pose moves against its translation, by noise and not by more: half of those at infinity.
int countBackwards(const PointColumnsView& points, const TwoViewPose& pose, const std::vector<float>& residuals,
                   float variance) {
  const Eigen::Matrix3f R = pose.R.cast<float>();
  const Eigen::Vector3f t = pose.t.cast<float>();
  int count = 0;
  for (int i = 0; i < points.count; ++i) {
    const RotatedMatch match(points, i, R);
    // The way of a point that comes from infinity, times a depth.
    const float way_x = t.x() - match.x * t.z(), way_y = t.y() - match.y * t.z();
    const float along = match.weight * (match.dx * way_x + match.dy * way_y);
    // A displacement has the noise of both images.
    const float farthest = 2 * kFurther * variance * match.weight * (way_x * way_x + way_y * way_y);
    count += (along < 0) & (along * along < farthest) & (residuals[static_cast<size_t>(i)] < kMostCost * variance);
  }
  return count;
}

/// Covariance of a rotation of the reference frame, from its normal equations over `count` matches cut at a residual
/// of 1.
Eigen::Matrix3d covarianceOf(const NormalEquations<3>& equations, int count, const Eigen::Matrix3d& R) {
  constexpr int kComponents = 2, kFreedoms = 3;
  const double inliers = static_cast<double>(equations.weight);
  const double squares = static_cast<double>(equations.cost) - (count - inliers);
  const double variance = std::max(squares, 1e-12) / std::max(1.0, kComponents * inliers - kFreedoms);
  Eigen::Matrix3d A;
  for (int i = 0, k = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, ++k) A(i, j) = A(j, i) = static_cast<double>(equations.matrix[k]);
  }
  const Eigen::LLT<Eigen::Matrix3d> factors(A);
  if (factors.info() != Eigen::Success) return variance * Eigen::Matrix3d::Identity();
  return variance * (R.transpose() * factors.solve(R));
}

}  // namespace

DirectionDoubt RotationVerdict::doubt() const {
  if (against_rotation < kLeastAgainstRotation || against_rolling < 0) return DirectionDoubt::kTurn;
  if (static_share > kMostStatic || share_at_infinity > kMostAtInfinity) return DirectionDoubt::kStill;
  return DirectionDoubt::kNone;
}

bool RotationVerdict::rotationIsBetter() const { return against_rotation < 0 || against_rolling < 0; }

bool RotationVerdict::onlyRotated() const { return static_share > kMostStatic || against_rotation < 0; }

const RotationOnly& RotationExplanation::fit(const ResidualKernels& kernels, const PointColumnsView& points,
                                             const TwoViewPose& start, const MatchNoise& noise) {
  const PoseModel model(kernels, points);
  RotationOnly& result = rotation_;
  result.R = start.R;
  // To the threshold's own scale, or twice what noise of both images amounts to.
  const auto last = static_cast<float>(std::min(2., 8 * noise.sigma() * noise.sigma()));
  const PointColumnsView part = firstColumns(points, kFittedMatches);
  for (const float softness : kSoftness) {
    PoseModel(kernels, part).refineRotation({1e12f, 1 / softness}, kIterations, result.R);
  }
  model.refineRotation({1e12f, 1 / last}, kIterations, result.R);
  model.rotationResiduals(result.R, result.residuals);
  sorted_.clear();
  for (int i = 0; i < points.count; ++i) {
    const auto column = static_cast<size_t>(i);
    if (noise.residuals()[column] < 1) sorted_.push_back(std::sqrt(result.residuals[column] / points.weight[i]));
  }
  result.median_parallax = sorted_.empty() ? 0 : nthSmallest(sorted_, sorted_.size() / 2);
  NormalEquations<3> equations;
  model.linearizeRotation(result.R, {1, 0}, equations);
  result.covariance = covarianceOf(equations, points.count, result.R);
  return result;
}

RotationVerdict RotationExplanation::compare(const TwoViewPoints& points, const TwoViewPose& pose,
                                             const MatchNoise& noise) {
  const double variance = noise.sigma() * noise.sigma();
  const auto per_variance = static_cast<float>(1 / variance);
  const auto count = static_cast<size_t>(points.size());
  pose_costs_.resize(count);
  costs_.resize(count);
  int inliers = 0, near = 0, further = 0;
  for (size_t i = 0; i < count; ++i) {
    const float e = noise.residuals()[i] * per_variance;
    // A transfer distance has the noise of both images.
    const float moved = 0.5f * rotation_.residuals[i] * per_variance;
    pose_costs_[i] = std::min(e, kMostCost) + kDepthCost;
    costs_[i] = std::min(moved, kMostRotationCost);
    if (!(e < kMostCost)) continue;
    ++inliers;
    const float along = moved - e;  // squared, without the part across the epipolar line
    near += along < kNear;
    further += along >= kNear && along < kFurther;
  }
  const auto against = [&] {
    return vuongStatistic(points.size(), points.cells(), by_cell_,
                          [&](size_t i) { return costs_[i] - pose_costs_[i]; });
  };
  RotationVerdict verdict;
  if (inliers > 0) {
    const int backwards = countBackwards(points.view(), pose, noise.residuals(), static_cast<float>(variance));
    verdict.static_share = countStatic(near, further) / inliers;
    verdict.share_at_infinity = 2. * backwards / inliers;
  }
  verdict.against_rotation = against();
  fitRolling(points.view(), per_variance);
  verdict.against_rolling = against();
  return verdict;
}

void RotationExplanation::fitRolling(const PointColumnsView& points, float inverse_variance) {
  const Eigen::Matrix3f R = rotation_.R.cast<float>();
  Eigen::Matrix3f rates = Eigen::Matrix3f::Zero();
  for (const float softness : kRollingSoftness) {
    RollingEquations equations;
    for (int i = 0; i < std::min(points.count, kFittedMatches); ++i) {
      const RotatedMatch match(points, i, R);
      const float falloff = 1 / (1 + match.cost(rates, inverse_variance) / softness);
      equations.add(match, match.weight * falloff * falloff);
    }
    rates = equations.solve();
  }
  for (int i = 0; i < points.count; ++i) {
    costs_[static_cast<size_t>(i)] =
        std::min(RotatedMatch(points, i, R).cost(rates, inverse_variance), kMostRotationCost);
  }
}

}  // namespace gms_ransac
