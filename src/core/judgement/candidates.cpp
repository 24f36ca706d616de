#include "judgement/candidates.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <Eigen/Cholesky>

#include "support/order_statistics.h"

namespace gms_ransac {

namespace {

// Limits of the statistic, from which on the pose counts as better: than a rotation, or where mostly chance decides, a
// quantile of the normal distribution. The lower one holds against another motion, unless it is that of a plane.
constexpr double kSurelyBetter = 2.5, kLeastVuong = 0.75;
/// So many steps on a part of the matches show which cannot come near: those that are surely worse there.
constexpr int kFirstIterations = 2;
/// Motions whose directions are closer, in standard deviations, are one that has not converged.
constexpr double kSameSigmas = 5;

/// Share of the inliers without parallax, beyond which a body that moves by itself may be all that moves.
constexpr double kMostStatic = 0.45;

/// How far the statistic is believed where explanations are weighed: 1 is the letter of a likelihood ratio of
/// independent cells, and too much. From 6 to 24 the recordings differ little.
constexpr double kBelief = 12;
/// Typical rate of rotation by row of a rolling shutter, as a share of the pair's rotation: the shutter reads an image
/// in less than the time between two. The second, radians per focal length, holds where the rotation goes to and fro.
constexpr double kShareOfRotation = 0.3, kLeastRate = 0.5 * M_PI / 180;
/// Typical translation past a plane, of its distance.
constexpr double kPlaneStep = 0.15;
/// Softness of the loss of each step of the plane's fit, squared deviations, from coarse to fine; the last two steps
/// are those of all matches that take part.
constexpr float kPlaneSoftness[] = {900, 300, 100, 30, 9, 9, 9};

constexpr float kMostCost = 9;  ///< of a wrong match: three standard deviations
/// A rotation saves the depth that a pose gives each match: log 4 (Torr 1998, lambda_1 for coordinates of dimension 4).
constexpr auto kDepthCost = static_cast<float>(2 * M_LN2);
// Squared parallax along the epipolar line: what noise mostly stays below, and hardly exceeds.
constexpr float kNear = 1.5f * 1.5f, kFurther = 3.5f * 3.5f;

/// Squared softness of the loss of each stage of the fit of a rotation, thresholds: near points of a translating camera
/// drop out.
constexpr float kSoftness[] = {100, 10, 2};
constexpr int kRotationIterations = 3;
constexpr float kTiny = 1e-18f;  ///< keeps points on the line at infinity finite

/// The displacement of a match after a rotation.
struct RotatedMatch {
  Eigen::Vector2f place, displacement;  ///< of the reference point after the rotation, and to the current point
  Eigen::Matrix<float, 2, 3> flow;      ///< derivative of the place by a small rotation
  Eigen::Vector3f rows;  ///< 1, the image row in the reference, and by how much it differs in the current
  float weight;

  RotatedMatch(const PointColumnsView& points, int slot, const Eigen::Matrix3f& R)
      : rows(1, points.y1[slot], points.y2[slot] - points.y1[slot]), weight(points.weight[slot]) {
    const Eigen::Vector3f ray = R * Eigen::Vector3f(points.x1[slot], points.y1[slot], 1);
    place = ray.head<2>() * (ray.z() / (ray.z() * ray.z() + kTiny));
    displacement = Eigen::Vector2f(points.x2[slot], points.y2[slot]) - place;
    const float x = place.x(), y = place.y();
    flow << -x * y, 1 + x * x, -y, -(1 + y * y), x * y, x;
  }

  /// Squared deviations of a displacement, which has the noise of both images.
  float cost(const Eigen::Vector2f& rest, float per_variance) const {
    return 0.5f * per_variance * weight * rest.squaredNorm();
  }
};

// Motions of a match that the rotation does not explain: rest() is the displacement that they leave.

struct RollingShutter {
  Eigen::Matrix3f rates = Eigen::Matrix3f::Zero();  ///< columns: radians by each of RotatedMatch::rows

  Eigen::Vector2f rest(const RotatedMatch& match) const {
    return match.displacement - match.flow * (rates * match.rows);
  }
};

struct MotionPastPlane {
  Eigen::Matrix<float, 6, 1> step;  ///< a rotation vector, translation over distance

  static Eigen::Matrix<float, 2, 6> derivative(const RotatedMatch& match) {
    Eigen::Matrix<float, 2, 6> J;
    J << match.flow, Eigen::Matrix2f::Identity(), -match.place;
    return J;
  }
  Eigen::Vector2f rest(const RotatedMatch& match) const { return match.displacement - derivative(match) * step; }
};

/// Sums up a step of reweighted least squares over the first `count` slots: calls add(slot, match, rest, falloff), the
/// root of the loss's weight.
template <class Motion, class Add>
void sumReweighted(const RefinedPose& refined, const Eigen::Matrix3f& R, const Motion& motion, int count,
                   float softness, const Add& add) {
  const PointColumnsView points = refined.points->view();
  const float per_variance = refined.perVariance();
  for (int slot = 0; slot < count; ++slot) {
    const RotatedMatch match(points, slot, R);
    const Eigen::Vector2f rest = motion.rest(match);
    add(static_cast<size_t>(slot), match, rest, 1 / (1 + match.cost(rest, per_variance) / softness));
  }
}

/// vuongStatistic of the pose against a motion on the first `count` slots. `cost(slot)`: the motion's; `most`: of any.
template <class Cost>
double poseAgainst(const RefinedPose& refined, int count, float most, const Cost& cost) {
  const float per_variance = refined.perVariance();
  const std::vector<float>& squares = refined.noise.residuals();
  return vuongStatistic(count, refined.points->cells(), [&](size_t slot) {
    return std::min(cost(slot), most) - std::min(squares[slot] * per_variance, most);
  });
}

/// The same against a rotation with what moves the matches besides.
template <class Motion>
double poseAgainstRotation(const RefinedPose& refined, const Eigen::Matrix3f& R, const Motion& motion, int count) {
  const PointColumnsView points = refined.points->view();
  const float per_variance = refined.perVariance();
  return poseAgainst(refined, count, kMostCost, [&](size_t slot) {
    const RotatedMatch match(points, static_cast<int>(slot), R);
    return match.cost(motion.rest(match), per_variance) - kDepthCost;
  });
}

/// Matches for each cell that has some: so many weigh as much as one observation of a prior.
double matchesOfCell(const std::vector<int32_t>& cells) {
  std::array<bool, kCellCount> seen = {};
  for (const int32_t cell : cells) seen[static_cast<size_t>(cell)] = true;
  return static_cast<double>(cells.size()) /
         static_cast<double>(std::max<long>(1, std::count(seen.begin(), seen.end(), true)));
}

/// The place of an entry of a symmetric matrix in its lower triangle, and that triangle by rows.
int triangleEntry(int i, int j) { return i < j ? triangleEntry(j, i) : i * (i + 1) / 2 + j; }
Eigen::Matrix<double, 6, 1> lowerTriangle(const Eigen::Matrix3f& m) {
  Eigen::Matrix<float, 6, 1> entries;
  entries << m(0, 0), m(1, 0), m(1, 1), m(2, 0), m(2, 1), m(2, 2);
  return entries.cast<double>();
}

/// The opposite direction is another motion: with a rotation that compensates for it, near and far change places.
double angleBetween(const TwoViewPose& a, const TwoViewPose& b) {
  return std::acos(std::clamp(a.t.dot(b.t), -1.0, 1.0));
}

/// From one pose to another in the parameters of PoseModel::linearize.
PoseVector poseStep(const TwoViewPose& from, const TwoViewPose& to) {
  const Eigen::Vector3d t = to.t.dot(from.t) < 0 ? Eigen::Vector3d(-to.t) : to.t;
  Eigen::Vector3d basis[2];
  PoseModel::tangent(from.t, basis);
  PoseVector step;
  step << rotationVector(to.R * from.R.transpose()), basis[0].dot(t), basis[1].dot(t);
  return step;
}

/// Fits the rates of a rolling shutter, which are the solution of each step, and compares them.
double againstRolling(const RefinedPose& refined, const Eigen::Matrix3d& rotation) {
  const int all = refined.points->size(), fitted = std::min(all, kRandomPart);
  const Eigen::Matrix3f R = rotation.cast<float>();
  const double rate = kLeastRate + kShareOfRotation * rotationVector(rotation).norm();
  const auto per_variance = static_cast<double>(refined.perVariance());
  const double prior = matchesOfCell(refined.points->cells()) / (rate * rate * per_variance);
  RollingShutter shutter;
  for (float softness = 9 * kMostCost;; softness /= 3) {
    // The derivative of a match is the outer product of its rows and its flow, and its square that of their squares,
    // whose lower triangles suffice.
    Eigen::Matrix<double, 6, 6> squares = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix3d b = Eigen::Matrix3d::Zero();
    sumReweighted(refined, R, shutter, fitted, softness,
                  [&](size_t, const RotatedMatch& match, const Eigen::Vector2f&, float falloff) {
                    const float weight = match.weight * falloff * falloff;
                    const Eigen::Matrix3f square = weight * match.flow.transpose() * match.flow;
                    const Eigen::Vector3f along = weight * match.flow.transpose() * match.displacement;
                    b += (along * match.rows.transpose()).cast<double>();
                    squares += lowerTriangle(square) * lowerTriangle(match.rows * match.rows.transpose()).transpose();
                  });
    Eigen::Matrix<double, 9, 9> A = 1e-9 * Eigen::Matrix<double, 9, 9>::Identity();  // the lower triangle counts
    A.diagonal().tail<6>().setConstant(prior);
    for (int i = 0; i < 9; ++i) {
      for (int j = 0; j <= i; ++j) A(i, j) += squares(triangleEntry(i % 3, j % 3), triangleEntry(i / 3, j / 3));
    }
    const Eigen::Matrix<double, 9, 1> solution = A.llt().solve(Eigen::Map<const Eigen::Matrix<double, 9, 1>>(b.data()));
    shutter.rates = Eigen::Map<const Eigen::Matrix3d>(solution.data()).cast<float>();
    const bool last = softness <= kMostCost;
    const double statistic = poseAgainstRotation(refined, R, shutter, last ? all : fitted);
    if (last || statistic > kSurelyBetter) return statistic;  // a narrower loss would not reverse that
  }
}

/// Fits the rotation of a camera that moves past a plane, and compares it.
Explanation pastPlane(const RefinedPose& refined, const Eigen::Matrix3d& rotation) {
  using Vector = Eigen::Matrix<double, 6, 1>;
  using Square = Eigen::Matrix<double, 6, 6>;
  const std::vector<int32_t>& cells = refined.points->cells();
  const int all = refined.points->size();
  const Eigen::Matrix3f R = rotation.cast<float>();
  const float per_variance = refined.perVariance();
  Vector prior = Vector::Constant(1e-9), motion = Vector::Zero();
  prior.tail<3>().setConstant(matchesOfCell(cells) / (kPlaneStep * kPlaneStep));
  Square information;
  std::array<Vector, kCellCount> pull_of_cell;
  int step = 0;
  for (const float softness : kPlaneSoftness) {
    const bool coarse = ++step + 2 <= static_cast<int>(std::size(kPlaneSoftness));
    information = prior.asDiagonal();
    pull_of_cell.fill(Vector::Zero());
    sumReweighted(refined, R, MotionPastPlane{motion.cast<float>()},
                  std::min(all, coarse ? kRandomPart : 2 * kRandomPart), softness,
                  [&](size_t slot, const RotatedMatch& match, const Eigen::Vector2f& rest, float falloff) {
                    const Eigen::Matrix<float, 2, 6> J = MotionPastPlane::derivative(match);
                    const float weight = per_variance * match.weight * falloff * falloff;
                    const Eigen::Matrix<float, 6, 1> pull = J.transpose() * (weight * rest);
                    const Eigen::Matrix<float, 6, 6> square = weight * J.transpose().lazyProduct(J);
                    pull_of_cell[static_cast<size_t>(cells[slot])] += pull.cast<double>();
                    information += square.cast<double>();
                  });
    Vector pull = -prior.cwiseProduct(motion);
    for (const Vector& cell : pull_of_cell) pull += cell;
    motion += information.llt().solve(pull);
  }
  // The sandwich, with the prior as one more observation.
  Square scatter = prior.asDiagonal();
  for (const Vector& cell : pull_of_cell) scatter += cell * cell.transpose();
  const Square inverse = information.llt().solve(Square::Identity());
  const Square covariance = inverse.lazyProduct(scatter).eval().lazyProduct(inverse);
  return {rotationFromVector(motion.head<3>()) * rotation, covariance.topLeftCorner<3, 3>(),
          poseAgainstRotation(refined, R, MotionPastPlane{motion.cast<float>()}, all)};
}

/// Refines a motion on the first `count` slots and compares it there; infinite if it converged to the pose: their
/// directions then agree to `same_within` radians.
double againstMotion(const RefinedPose& refined, double same_within, int count, int iterations,
                     std::vector<float>& residuals, TwoViewPose& motion) {
  refined.plausibleModel().first(count).refine(refined.noise.loss(), iterations, motion);
  if (angleBetween(motion, refined.pose) < same_within) return std::numeric_limits<double>::infinity();
  refined.model().first(count).residualsInFront(motion, residuals);
  const float per_variance = refined.perVariance();
  // Costs end at the threshold where that is less: a homography's is many times the noise.
  return poseAgainst(refined, count, std::min(kMostCost, per_variance), [&](size_t slot) {
    const bool plausible = refined.noise.plausible(static_cast<int>(slot));
    return (plausible ? residuals : refined.noise.residuals())[slot] * per_variance;
  });
}

/// Fills the shares of the verdict.
void countStatic(const RefinedPose& refined, const RotationAlone& alone, Verdict& verdict) {
  const PointColumnsView points = refined.points->view();
  const Eigen::Matrix3f R = refined.pose.R.cast<float>();
  const Eigen::Vector3f t = refined.pose.t.cast<float>();
  const float per_variance = refined.perVariance();
  int inliers = 0, near = 0, further = 0, backwards = 0;
  for (int slot = 0; slot < points.count; ++slot) {
    const auto s = static_cast<size_t>(slot);
    const float cost = refined.noise.residuals()[s] * per_variance;
    const bool inlier = cost < kMostCost;
    // Squared, without the part across the epipolar line.
    const float along = 0.5f * alone.residuals[s] * per_variance - cost;
    // The way of a point that comes from infinity, times a depth. Noise moves half of those there against it.
    const RotatedMatch match(points, slot, R);
    const Eigen::Vector2f way = t.head<2>() - t.z() * match.place;
    const float ahead = match.displacement.dot(way);
    const float farthest = 2 * kFurther / (per_variance * match.weight) * way.squaredNorm();
    inliers += inlier;
    near += inlier & (along < kNear);
    further += inlier & (along >= kNear) & (along < kFurther);
    backwards += inlier & (ahead < 0) & (ahead * ahead < farthest);
  }
  // Noise alone puts 86.6 and 13.3 % of those without parallax near and further; parallaxes that are spread over more
  // than the noise come there as the widths of the two, 1.5 to 2.
  const double noise_near = std::erf(std::sqrt(kNear / 2)), of_noise = std::erf(std::sqrt(kFurther / 2)) - noise_near;
  const double evenly = 1 / (std::sqrt(kFurther / kNear) - 1);
  const double still = std::max(0.0, (near - evenly * further) / (noise_near - evenly * of_noise));
  verdict.static_share = still / std::max(1, inliers);
  verdict.share_at_infinity = 2. * backwards / std::max(1, inliers);
}

}  // namespace

bool Verdict::onlyRotated() const { return static_share > kMostStatic || rotation < 0; }

void fitRotation(const RefinedPose& refined, RotationAlone& alone) {
  // To the threshold's own scale, or twice what noise of both images amounts to.
  const auto last = static_cast<float>(std::min(2., 8 * refined.noise.variance()));
  const PoseModel model = refined.model(), part = model.first(kRandomPart);
  alone.R = refined.pose.R;
  for (const float softness : kSoftness) part.refineRotation({1e12f, 1 / softness}, kRotationIterations, alone.R);
  model.refineRotation({1e12f, 1 / last}, kRotationIterations, alone.R);
  model.rotationResiduals(alone.R, alone.residuals);
  std::vector<float>& parallaxes = alone.parallaxes;
  parallaxes.clear();
  for (size_t slot = 0; slot < static_cast<size_t>(model.points().count); ++slot) {
    if (!(refined.noise.residuals()[slot] < 1)) continue;
    parallaxes.push_back(std::sqrt(alone.residuals[slot] / model.points().weight[slot]));
  }
  alone.median_parallax = parallaxes.empty() ? 0 : nthSmallest(parallaxes, parallaxes.size() / 2);
}

Eigen::Matrix3d rotationCovariance(const PoseModel& model, const Eigen::Matrix3d& R) {
  NormalEquations<3> equations;  // of residuals cut at 1
  model.linearizeRotation(R, {1, 0}, equations);
  const double inliers = static_cast<double>(equations.weight);
  const double squares = static_cast<double>(equations.cost) - (model.points().count - inliers);
  // Each match has two components, the rotation three degrees of freedom.
  const double variance = std::max(squares, 1e-12) / std::max(1.0, 2 * inliers - 3);
  Eigen::Matrix3d A;
  for (int i = 0, k = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, ++k) A(i, j) = A(j, i) = static_cast<double>(equations.matrix[k]);
  }
  const Eigen::LLT<Eigen::Matrix3d> factors(A);
  if (factors.info() != Eigen::Success) return variance * Eigen::Matrix3d::Identity();
  return variance * factors.solve(Eigen::Matrix3d::Identity());
}

Verdict compareRotations(const RefinedPose& refined, const RotationAlone& alone, bool shutter_may_roll) {
  const float per_variance = refined.perVariance();
  Verdict verdict;
  verdict.rotation = poseAgainst(refined, refined.points->size(), kMostCost, [&](size_t slot) {
    return 0.5f * alone.residuals[slot] * per_variance - kDepthCost;  // a transfer has the noise of both images
  });
  verdict.rolling = shutter_may_roll ? againstRolling(refined, alone.R) : verdict.rotation;
  countStatic(refined, alone, verdict);
  return verdict;
}

void compareMotions(const RefinedPose& refined, double direction_sigma, const std::vector<AlternativeMotion>& motions,
                    std::vector<float>& storage, Verdict& verdict) {
  const int count = refined.points->size(), first = std::min(kRandomPart, count);
  const double same_within = std::min(kSameSigmas * direction_sigma, kOtherDirection);
  for (const AlternativeMotion& alternative : motions) {
    TwoViewPose motion = alternative.pose;
    if (angleBetween(motion, refined.pose) < same_within) continue;
    if (againstMotion(refined, same_within, first, kFirstIterations, storage, motion) >= kSurelyBetter) continue;
    const double against = againstMotion(refined, same_within, count, kFinalIterations, storage, motion);
    if (against >= kSurelyBetter) continue;
    const double limit = alternative.of_plane ? kSurelyBetter : kLeastVuong;
    if (angleBetween(motion, refined.pose) > kOtherDirection) {
      verdict.other_motion = std::min(verdict.other_motion, against / limit);
    }
    if (against >= limit) continue;
    refined.plausibleModel().refine(refined.noise.loss(), kFinalIterations, motion, kEnough);
    const PoseVector step = poseStep(refined.pose, motion);
    verdict.spread += step * step.transpose();
  }
}

Explanation togetherOf(std::initializer_list<Explanation> explanations) {
  const Eigen::Matrix3d origin = explanations.begin()->R;
  double total = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (const Explanation& explanation : explanations) {
    const Eigen::Vector3d step = rotationVector(explanation.R * origin.transpose());
    const double weight = std::exp(-explanation.against * std::abs(explanation.against) / (2 * kBelief));
    if (!step.allFinite() || !explanation.covariance.allFinite() || !std::isfinite(weight)) continue;
    total += weight;
    mean += weight * step;
    moment += weight * (explanation.covariance + step * step.transpose());
  }
  if (!(total > 0)) return {origin, Eigen::Matrix3d::Identity(), 0};
  mean /= total;
  return {rotationFromVector(mean) * origin, moment / total - mean * mean.transpose(), 0};
}

Explanation rotationWithoutTranslation(const RefinedPose& refined, const RotationAlone& alone, const Verdict& verdict) {
  const PoseSquare covariance = refined.covariance.covariance + verdict.spread;
  return togetherOf({{refined.pose.R, covariance.topLeftCorner<3, 3>(), 0},
                     {alone.R, rotationCovariance(refined.model(), alone.R), verdict.rotation},
                     pastPlane(refined, alone.R)});
}

}  // namespace gms_ransac
