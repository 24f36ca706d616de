#include "judgement/rotation_explanation.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "judgement/vuong.h"
#include "order_statistics.h"

namespace gms_ransac {

namespace {

/// Share of the inliers without parallax, beyond which a body that moves by itself may be all that moves.
constexpr double kMostStatic = 0.45;
/// The same of those that the pose itself puts at infinity. Views of which two fifths are background show less.
constexpr double kMostAtInfinity = 0.4;

// Costs are squared standard deviations. A pose gives each match a depth, which costs log 4 (Torr 1998, lambda_1 for
// coordinates of dimension 4).
constexpr auto kDepthCost = static_cast<float>(2 * M_LN2), kMostRotationCost = kMostCost + kDepthCost;
// Squared parallax along the epipolar line: what noise mostly stays below, and hardly exceeds.
constexpr float kNear = 1.5f * 1.5f, kFurther = 3.5f * 3.5f;

/// Squared softness of the loss of each stage of the fit of a rotation, in thresholds, and of the first with rolling
/// shutter, in standard deviations: near points of a translating camera drop out.
constexpr float kSoftness[] = {100, 10, 2}, kRollingSoftness = 9 * kMostCost;
constexpr int kRotationIterations = 3;
constexpr float kTiny = 1e-18f;  ///< keeps points on the line at infinity finite

/// The displacement of a match after a rotation.
struct RotatedMatch {
  Eigen::Vector2f place, displacement;  ///< of the reference point after the rotation, and to the current point
  Eigen::Matrix<float, 2, 3> flow;      ///< derivative of the place by a small rotation
  Eigen::Vector3f rows;  ///< 1, the row in the reference image, and by how much it differs in the current
  float weight;

  RotatedMatch(const PointColumnsView& points, int i, const Eigen::Matrix3f& R)
      : rows(1, points.y1[i], points.y2[i] - points.y1[i]), weight(points.weight[i]) {
    const Eigen::Vector3f ray = R * Eigen::Vector3f(points.x1[i], points.y1[i], 1);
    place = ray.head<2>() * (ray.z() / (ray.z() * ray.z() + kTiny));
    displacement = Eigen::Vector2f(points.x2[i], points.y2[i]) - place;
    const float x = place.x(), y = place.y();
    flow << -x * y, 1 + x * x, -y, -(1 + y * y), x * y, x;
  }

  /// Squared deviations from the rotation whose rates by `rows` are the columns of `rates`, radians.
  float cost(const Eigen::Matrix3f& rates, float inverse_variance) const {
    return 0.5f * inverse_variance * weight * (displacement - flow * (rates * rows)).squaredNorm();
  }
};

/// How many matches have no parallax, by how many have less than 1.5 deviations of it along their epipolar lines, and
/// how many between that and 3.5. Noise alone puts 86.6 and 13.3 % there; parallaxes that are spread over more than the
/// noise put them there as the widths of the two, 1.5 to 2.
double countStatic(int near, int further) {
  const double noise_near = std::erf(std::sqrt(kNear / 2)),
               noise_further = std::erf(std::sqrt(kFurther / 2)) - noise_near;
  const double spread = 1 / (std::sqrt(kFurther / kNear) - 1);
  return std::max(0.0, (near - spread * further) / (noise_near - spread * noise_further));
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
    const Eigen::Vector2f way = t.head<2>() - t.z() * match.place;
    const float along = match.weight * match.displacement.dot(way);
    // A displacement has the noise of both images.
    const float farthest = 2 * kFurther * variance * match.weight * way.squaredNorm();
    count += (along < 0) & (along * along < farthest) & (residuals[static_cast<size_t>(i)] < kMostCost * variance);
  }
  return count;
}

}  // namespace

DirectionDoubt RotationVerdict::doubt() const {
  // Against a rotation with rolling shutter, which has six parameters more, it need only be positive.
  if (against_rotation < kSurelyBetter || against_rolling < 0) return DirectionDoubt::kRotationExplains;
  if (static_share > kMostStatic || share_at_infinity > kMostAtInfinity) return DirectionDoubt::kMostlyStatic;
  return DirectionDoubt::kNone;
}

bool RotationVerdict::onlyRotated() const { return static_share > kMostStatic || against_rotation < 0; }

const RotationOnly& RotationExplanation::fit(const ResidualKernels& kernels, const PointColumnsView& points,
                                             const TwoViewPose& start, const MatchNoise& noise) {
  const PoseModel model(kernels, points);
  rotation_.R = start.R;
  // To the threshold's own scale, or twice what noise of both images amounts to.
  const auto last = static_cast<float>(std::min(2., 8 * noise.sigma() * noise.sigma()));
  const PointColumnsView part = firstColumns(points, kRandomPart);
  for (const float softness : kSoftness) {
    PoseModel(kernels, part).refineRotation({1e12f, 1 / softness}, kRotationIterations, rotation_.R);
  }
  model.refineRotation({1e12f, 1 / last}, kRotationIterations, rotation_.R);
  model.rotationResiduals(rotation_.R, rotation_.residuals);
  sorted_.clear();
  for (int i = 0; i < points.count; ++i) {
    const auto column = static_cast<size_t>(i);
    if (noise.residuals()[column] < 1) sorted_.push_back(std::sqrt(rotation_.residuals[column] / points.weight[i]));
  }
  rotation_.median_parallax = sorted_.empty() ? 0 : nthSmallest(sorted_, sorted_.size() / 2);
  return rotation_;
}

Eigen::Matrix3d RotationExplanation::covariance(const ResidualKernels& kernels, const PointColumnsView& points) const {
  constexpr int kComponents = 2, kFreedoms = 3;
  NormalEquations<3> equations;  // of residuals cut at 1
  PoseModel(kernels, points).linearizeRotation(rotation_.R, {1, 0}, equations);
  const double inliers = static_cast<double>(equations.weight);
  const double squares = static_cast<double>(equations.cost) - (points.count - inliers);
  const double variance = std::max(squares, 1e-12) / std::max(1.0, kComponents * inliers - kFreedoms);
  Eigen::Matrix3d A;
  for (int i = 0, k = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, ++k) A(i, j) = A(j, i) = static_cast<double>(equations.matrix[k]);
  }
  const Eigen::LLT<Eigen::Matrix3d> factors(A);
  if (factors.info() != Eigen::Success) return variance * Eigen::Matrix3d::Identity();
  return variance * (rotation_.R.transpose() * factors.solve(rotation_.R));
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
  RotationVerdict verdict;
  if (inliers > 0) {
    const int backwards = countBackwards(points.view(), pose, noise.residuals(), static_cast<float>(variance));
    verdict.static_share = countStatic(near, further) / inliers;
    verdict.share_at_infinity = 2. * backwards / inliers;
  }
  verdict.against_rotation =
      vuongStatistic(points.size(), points.cells(), by_cell_, [&](size_t i) { return costs_[i] - pose_costs_[i]; });
  verdict.against_rolling = againstRolling(points, per_variance);
  return verdict;
}

double RotationExplanation::againstRolling(const TwoViewPoints& all, float inverse_variance) {
  const PointColumnsView points = all.view();
  const int fitted = std::min(points.count, kRandomPart);
  const Eigen::Matrix3f R = rotation_.R.cast<float>();
  Eigen::Matrix3f rates = Eigen::Matrix3f::Zero();
  for (float softness = kRollingSoftness;; softness /= 3) {
    // The derivative of a match is the outer product of its rows and its flow.
    Eigen::Matrix<double, 9, 9> A = 1e-9 * Eigen::Matrix<double, 9, 9>::Identity();  // the lower triangle counts
    Eigen::Matrix<double, 9, 1> b = Eigen::Matrix<double, 9, 1>::Zero();
    for (int i = 0; i < fitted; ++i) {
      const RotatedMatch match(points, i, R);
      const float falloff = 1 / (1 + match.cost(rates, inverse_variance) / softness);
      const float weight = match.weight * falloff * falloff;
      const Eigen::Matrix3f square = weight * match.flow.transpose() * match.flow;
      const Eigen::Vector3f along = weight * match.flow.transpose() * match.displacement;
      for (int k = 0; k < 3; ++k) {
        b.segment<3>(3 * k) += (match.rows[k] * along).cast<double>();
        for (int m = 0; m <= k; ++m) {
          A.block<3, 3>(3 * k, 3 * m) += (match.rows[k] * match.rows[m] * square).cast<double>();
        }
      }
    }
    const Eigen::Matrix<double, 9, 1> solution = A.llt().solve(b);
    rates = Eigen::Map<const Eigen::Matrix3d>(solution.data()).cast<float>();
    const bool last = softness <= kMostCost;
    const int count = last ? points.count : fitted;
    for (int i = 0; i < count; ++i) {
      costs_[static_cast<size_t>(i)] =
          std::min(RotatedMatch(points, i, R).cost(rates, inverse_variance), kMostRotationCost);
    }
    const double statistic =
        vuongStatistic(count, all.cells(), by_cell_, [&](size_t i) { return costs_[i] - pose_costs_[i]; });
    if (last || statistic > kSurelyBetter) return statistic;  // a narrower loss would not reverse that
  }
}

}  // namespace gms_ransac
