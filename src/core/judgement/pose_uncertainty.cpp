#include "judgement/pose_uncertainty.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

/// What the camera model may get wrong: focal length, principal point (x, y), radial distortion, turns about x, y and z
/// while the rows of the reference and of the current image are read.
enum Unmodelled { kFocalLength, kPrincipalPoint, kRadialDistortion = 3, kRowsReference, kRowsCurrent = 7, kCount = 10 };

constexpr double kDegree = M_PI / 180;
constexpr double kRowsSigma = 2 * kDegree;
/// What cameras in use are off by where they are: relative focal length, principal point in focal lengths, the first
/// coefficient of radial distortion, radians by a focal length's worth of rows.
const Eigen::Matrix<double, kCount, 1> kUnmodelledSigma =
    (Eigen::Matrix<double, kCount, 1>() << 0.03, 0.01, 0.01, 0.03, kRowsSigma, kRowsSigma, kRowsSigma, kRowsSigma,
     kRowsSigma, kRowsSigma)
        .finished();

/// Parameters that are tested together, and what chi-square with as many degrees of freedom exceeds in 1 % of cases.
struct TestedTogether {
  CameraParameter parameter;
  Unmodelled first;
  int count;
  double limit;
};
constexpr TestedTogether kTests[] = {{CameraParameter::kFocalLength, kFocalLength, 1, 6.63},
                                     {CameraParameter::kPrincipalPoint, kPrincipalPoint, 2, 9.21},
                                     {CameraParameter::kRadialDistortion, kRadialDistortion, 1, 6.63},
                                     {CameraParameter::kRollingShutter, kRowsReference, 6, 16.81}};

// From here on the doubt about the camera model grows until the model without doubt is left (doc/uncertainty.md).
constexpr double kFirstDoubt = 0.5, kFullDoubt = 0.9;
constexpr double kLeastCurvature = 0.05;  ///< of the loss, of 1 at its bottom

constexpr int kShifts = 7;  ///< of one image

/// What a small step of each of the parameters does to a residual through the point `q` of the normalised image plane:
/// a focal length, a principal point (x, y), a radial distortion, turns about x, y and z by y radians. `n`: derivative
/// of the residual by the point; `share`: residual over the squared length of both such derivatives, because a shift
/// that stretches the image stretches its noise. Derived in doc/uncertainty.md.
Eigen::Matrix<double, kShifts, 1> byShifts(const Eigen::Vector2d& n, const Eigen::Vector2d& q, double share) {
  const double x = q.x(), y = q.y(), a = n.x(), b = n.y();
  const double aa = a * a, ab = a * b, bb = b * b, along = a * x + b * y, squared = x * x + y * y;
  Eigen::Matrix<double, kShifts, 1> effect;
  effect << -along + share * (aa + bb), -a, -b, squared * along - share * (squared * (aa + bb) + 2 * along * along),
      -y * (a * x * y + b * (1 + y * y)) + share * (aa * y * y + 2 * ab * x * y + bb * (1 + 3 * y * y)),
      y * (a * (1 + x * x) + b * x * y) - share * (2 * (aa + bb) * x * y + ab * (1 + squared)),
      y * (b * x - a * y) - share * (bb * x - ab * y);
  return effect;
}

}  // namespace

double PoseSpread::directionSigma() const {
  const Eigen::Matrix2d direction = covariance.bottomRightCorner<2, 2>();
  const double half_trace = 0.5 * direction.trace();
  return std::sqrt(half_trace + std::sqrt(std::max(0.0, half_trace * half_trace - direction.determinant())));
}

PoseUncertainty::Row PoseUncertainty::jacobian(const PointColumnsView& points, int column, const TwoViewPose& pose,
                                               const Eigen::Matrix3d& E, const Eigen::Vector3d (&basis)[2],
                                               double& residual) {
  // doc/residual_kernels.md: value C, squared gradient N, k = C / N; here divided by sqrt(N / w).
  const Eigen::Vector3d p(points.x1[column], points.y1[column], 1), q(points.x2[column], points.y2[column], 1);
  const Eigen::Vector3d turned = pose.R * p, line2 = E * p, line1 = E.transpose() * q;
  const double N = line2.head<2>().squaredNorm() + line1.head<2>().squaredNorm();
  const double unit = std::sqrt(points.weight[column] / N), C = q.dot(line2), k = C / N;
  residual = unit * C;

  // d(rho) = <G, dE> with G = q' p^T - q c^T.
  const Eigen::Vector3d q_moved = q - k * Eigen::Vector3d(line2.x(), line2.y(), 0);
  const Eigen::Vector3d c_moved = k * pose.R * Eigen::Vector3d(line1.x(), line1.y(), 0);
  Row J;
  // dE = [t]x [w]x R and [step]x R.
  J.head<3>() = unit * (turned.cross(q_moved.cross(pose.t)) - c_moved.cross(q.cross(pose.t)));
  const Eigen::Vector3d by_t = turned.cross(q_moved) - c_moved.cross(q);
  for (int i = 0; i < 2; ++i) J[3 + i] = unit * basis[i].dot(by_t);

  // Gradients by the two points, whose noise a shift stretches as well.
  const Eigen::Vector2d n1 = unit * (line1.head<2>() - k * E.topLeftCorner<2, 2>().transpose() * line2.head<2>());
  const Eigen::Vector2d n2 = unit * (line2.head<2>() - k * E.topLeftCorner<2, 2>() * line1.head<2>());
  const double share = residual / (n1.squaredNorm() + n2.squaredNorm());
  const auto effect1 = byShifts(n1, p.head<2>(), share), effect2 = byShifts(n2, q.head<2>(), share);
  J.segment<kRowsReference>(kPose) = effect1.head<kRowsReference>() + effect2.head<kRowsReference>();
  J.segment<3>(kPose + kRowsReference) = effect1.tail<3>();
  J.segment<3>(kPose + kRowsCurrent) = effect2.tail<3>();
  return J;
}

int PoseUncertainty::sumUp(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
                           const std::vector<int32_t>& cells) {
  const Loss loss = noise.loss();
  const Eigen::Matrix3d E = pose.essential();
  Eigen::Vector3d basis[2];
  PoseModel::tangent(pose.t, basis);
  curvature_.setZero();
  cell_gradients_.assign(static_cast<size_t>(kSpreadGridSide) * kSpreadGridSide, Row::Zero());
  double bend = 0;
  int used = 0;
  for (int i = 0; i < points.count; ++i) {
    const double e = noise.residuals()[static_cast<size_t>(i)];
    if (!(e < loss.cut) || !noise.plausible(i)) continue;
    double residual;
    const Row J = jacobian(points, i, pose, E, basis, residual);
    const double falloff = 1 / (1 + e * loss.inverse_softness), weight = falloff * falloff;
    curvature_.selfadjointView<Eigen::Upper>().rankUpdate(J);
    bend += weight * falloff * (1 - 3 * e * loss.inverse_softness);
    cell_gradients_[static_cast<size_t>(cells[static_cast<size_t>(i)])] += weight * residual * J;
    ++used;
  }
  if (used == 0) return 0;
  curvature_.triangularView<Eigen::StrictlyLower>() = curvature_.transpose();
  // The mean second derivative of the loss; each match's own is noisy, and negative in the tails.
  curvature_ *= std::max(bend / used, kLeastCurvature);

  scatter_.setZero();
  gradient_.setZero();
  int clusters = 0;
  for (const Row& gradient : cell_gradients_) {
    if (gradient.isZero()) continue;
    scatter_.selfadjointView<Eigen::Upper>().rankUpdate(gradient);
    gradient_ += gradient;
    ++clusters;
  }
  scatter_.triangularView<Eigen::StrictlyLower>() = scatter_.transpose();
  scatter_ *= static_cast<double>(clusters) / std::max(1, clusters - kPose);
  return used;
}

PoseSpread PoseUncertainty::measure(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
                                    const std::vector<int32_t>& cells, const CalibrationSigma& calibration) {
  PoseSpread spread;
  if (sumUp(points, pose, noise, cells) < kAll) return spread;
  const Eigen::LDLT<Eigen::Matrix<double, kPose, kPose>> factors(curvature_.topLeftCorner<kPose, kPose>());
  if (factors.info() != Eigen::Success || !factors.isPositive()) return spread;
  const Eigen::Matrix<double, kPose, kPose> inverse = factors.solve(Eigen::Matrix<double, kPose, kPose>::Identity());
  // Huber's sandwich, clustered (Liang & Zeger 1986): noise of one neighbourhood may be common to it. The pose may lie
  // beside the optimum where nothing refined it.
  const Eigen::Matrix<double, kPose, 1> step = inverse * gradient_.head<kPose>();
  spread.covariance = inverse * scatter_.topLeftCorner<kPose, kPose>() * inverse + step * step.transpose();
  testModel(inverse, spread);
  const double doubt = std::clamp((spread.contradiction - kFirstDoubt) / (kFullDoubt - kFirstDoubt), 0.0, 1.0);
  if (doubt > 0) {
    const double variance = noise.sigma() * noise.sigma();
    spread.covariance += doubt * (extendedCovariance(kUnmodelledSigma, variance) - spread.covariance);
  }
  const Eigen::Vector3d sigma(calibration.focal_length, calibration.principal_point, calibration.principal_point);
  const Eigen::Matrix<double, kPose, 3> effect = inverse * curvature_.block<kPose, 3>(0, kPose) * sigma.asDiagonal();
  spread.covariance += effect * effect.transpose();
  if (!spread.covariance.allFinite()) spread.covariance.setIdentity();
  return spread;
}

void PoseUncertainty::testModel(const Eigen::Matrix<double, kPose, kPose>& inverse, PoseSpread& spread) const {
  // Rao's score test: what the pose does not explain of the gradient by the other parameters, over its own scatter.
  Eigen::Matrix<double, kUnmodelledCount, kAll> unexplained;
  unexplained << -curvature_.bottomLeftCorner<kUnmodelledCount, kPose>() * inverse,
      Eigen::Matrix<double, kUnmodelledCount, kUnmodelledCount>::Identity();
  const Eigen::Matrix<double, kUnmodelledCount, 1> score = unexplained * gradient_;
  const Eigen::Matrix<double, kUnmodelledCount, kUnmodelledCount> covariance =
      unexplained * scatter_ * unexplained.transpose();
  for (const TestedTogether& test : kTests) {
    using Scores = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kUnmodelledCount, 1>;
    using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kUnmodelledCount, kUnmodelledCount>;
    const Scores part = score.segment(test.first, test.count);
    const Covariance block = covariance.block(test.first, test.first, test.count, test.count);
    const double statistic = part.dot(block.ldlt().solve(part)) / test.limit;
    if (!(statistic > spread.contradiction)) continue;
    spread.contradiction = statistic;
    spread.contradicted = test.parameter;
  }
}

Eigen::Matrix<double, 5, 5> PoseUncertainty::extendedCovariance(const Eigen::Matrix<double, kUnmodelledCount, 1>& sigma,
                                                                double variance) const {
  Information information = curvature_, scatter = scatter_;
  for (int i = 0; i < kUnmodelledCount; ++i) {
    const double prior = variance / (sigma[i] * sigma[i]);
    information(kPose + i, kPose + i) += prior;
    scatter(kPose + i, kPose + i) += variance * prior;
  }
  const Information inverse = information.ldlt().solve(Information::Identity());
  const Eigen::Matrix<double, kPose, 1> step = (inverse * gradient_).head<kPose>();
  return (inverse * scatter * inverse).topLeftCorner<kPose, kPose>() + step * step.transpose();
}

Eigen::Matrix<double, 6, 6> relativeCovariance(const TwoViewPose& pose, const Eigen::Matrix<double, 5, 5>& covariance) {
  // With R' = R^T and t' = -R^T t: R' <- exp(-R^T w) R', and t' <- t' - R^T [t]x w - R^T (step).
  Eigen::Vector3d basis[2];
  PoseModel::tangent(pose.t, basis);
  const Eigen::Matrix3d Rt = pose.R.transpose();
  Eigen::Matrix<double, 6, 5> J = Eigen::Matrix<double, 6, 5>::Zero();
  J.topLeftCorner<3, 3>() = -Rt * crossMatrix(pose.t);
  for (int k = 0; k < 2; ++k) J.block<3, 1>(0, 3 + k) = -Rt * basis[k];
  J.bottomLeftCorner<3, 3>() = -Rt;
  return J * covariance * J.transpose();
}

}  // namespace gms_ransac
