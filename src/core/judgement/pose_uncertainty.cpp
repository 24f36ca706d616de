#include "judgement/pose_uncertainty.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "judgement/lanes.h"
#include "judgement/residual_derivatives.h"

namespace gms_ransac {

namespace {

// Between them the camera's parameters become free, where a preferred rotation is weighed (doc/uncertainty.md).
constexpr double kFirstDoubt = 0.5, kFullDoubt = 0.9;
// Of a correlation matrix: what the rounding of an inverse may leave of asymmetry and of negative eigenvalues.
constexpr double kInversionTolerance = 1e-8;
constexpr double kLeastCurvature = 0.05;  ///< of the loss, of 1 at its bottom
constexpr int kEnoughCells = 100;         ///< for the sandwich to hold, of 400
/// Noise is taken to be at most this share of what the matches seem to tell of the direction: how much it is, is itself
/// known to a few percent only.
constexpr double kMostNoise = 0.9;
/// Of a cell, from which on its gradient is that at the pose without it. What it hides is no more than a fifth below.
constexpr double kHighLeverage = 0.2;

/// Not finite where the information does not suffice.
PoseSquare inverseOf(const PoseSquare& information) {
  const Eigen::LDLT<PoseSquare> factors(information);
  if (factors.info() != Eigen::Success || !factors.isPositive()) return PoseSquare::Constant(NAN);
  return factors.solve(PoseSquare::Identity());
}

/// False of what the inverse of an ill-conditioned curvature makes: then rounding alone says what the pose is known to.
bool isCovariance(const PoseSquare& matrix) {
  if (!matrix.allFinite() || matrix.diagonal().minCoeff() < 0) return false;
  const Eigen::Matrix<double, kPoseParameters, 1> sigma = matrix.diagonal().cwiseSqrt();
  PoseSquare correlation = PoseSquare::Identity();
  for (int i = 0; i < kPoseParameters; ++i) {
    for (int j = 0; j < kPoseParameters; ++j) {
      if (sigma[i] * sigma[j] > 0) correlation(i, j) = matrix(i, j) / (sigma[i] * sigma[j]);
    }
  }
  if (!((correlation - correlation.transpose()).cwiseAbs().maxCoeff() < kInversionTolerance)) return false;
  const Eigen::LDLT<PoseSquare> factors(correlation);
  return factors.info() == Eigen::Success && factors.vectorD().minCoeff() > -kInversionTolerance;
}

}  // namespace

double directionSigma(const PoseSquare& covariance) {
  const Eigen::Matrix2d direction = covariance.bottomRightCorner<2, 2>();
  const double half_trace = 0.5 * direction.trace();
  return std::sqrt(half_trace + std::sqrt(std::max(0.0, half_trace * half_trace - direction.determinant())));
}

void PoseUncertainty::collect(const PointColumnsView& points, const MatchNoise& noise, float cut) {
  // Storage for all of them, so that how many take part allocates nothing.
  const auto size = static_cast<size_t>(points.size);
  used_.reserve(size);
  columns_.resize(points.count);
  J_.resize(std::max(J_.size(), kAll * size));
  turns_.resize(std::max(turns_.size(), 2 * size));
  pulls_.resize(std::max(pulls_.size(), size));
  used_.clear();
  for (int i = 0; i < points.count; ++i) {
    if (noise.residuals()[static_cast<size_t>(i)] < cut && noise.plausible(i)) used_.push_back(i);
  }
  columns_.gather(points, used_.data(), static_cast<int>(used_.size()));
}

double PoseUncertainty::differentiate(const TwoViewPose& pose, const Loss& loss) {
  const PointColumnsView used = columns_.view();
  const ResidualDerivatives derivatives(pose);
  Lanes bend = Lanes::Zero();
  for (int i = 0; i < used.size; i += kLanesAtOnce) {
    const Lanes residual = derivatives.write(used, i, J_.data() + i, turns_.data() + i, used.size);
    const Lanes softened = residual * residual * loss.inverse_softness, falloff = (1 + softened).inverse();
    const Lanes weight = falloff * falloff;
    lanes(pulls_.data() + i) = weight * residual;
    bend += weight * falloff * (1 - 3 * softened);
  }
  // Padding has no residual.
  return (static_cast<double>(bend.sum()) - (used.size - used.count)) / used.count;
}

int PoseUncertainty::sumByCell(const std::vector<int32_t>& cells) {
  const int stride = columns_.view().size;
  gradients_.resize(static_cast<size_t>(kAll) * kCells);
  const auto clear = [this](int cluster) {
    for (size_t k = 0; k < kAll; ++k) gradients_[k * kCells + static_cast<size_t>(cluster)] = 0;
  };
  cluster_of_.assign(kCells, -1);
  int clusters = 0;
  for (size_t i = 0; i < used_.size(); ++i) {
    int& cluster = cluster_of_[static_cast<size_t>(cells[static_cast<size_t>(used_[i])])];
    if (cluster < 0) clear(cluster = clusters++);
    const float* J = J_.data() + i;
    double* gradient = gradients_.data() + cluster;
    for (int k = 0; k < kAll; ++k) gradient[k * kCells] += static_cast<double>(pulls_[i] * J[k * stride]);
  }
  for (int padding = clusters; padding % kLanesAtOnce != 0; ++padding) clear(padding);
  return clusters;
}

int PoseUncertainty::sumUp(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
                           const std::vector<int32_t>& cells) {
  const Loss loss = noise.loss();
  collect(points, noise, loss.cut);
  if (used_.empty()) return 0;
  // The mean second derivative of the loss; each match's own is noisy, and negative in the tails.
  bend_ = std::max(differentiate(pose, loss), kLeastCurvature);
  const int size = columns_.view().size;
  curvature_ = bend_ * sumProducts<kAll>(J_.data(), size, size);

  clusters_ = sumByCell(cells);
  // In double: what the parameters do beside each other is a small difference of these sums.
  const int rows = (clusters_ + kLanesAtOnce - 1) / kLanesAtOnce * kLanesAtOnce;
  scatter_ = sumProducts<kAll>(gradients_.data(), kCells, rows);
  scatter_ *= static_cast<double>(clusters_) / std::max(1, clusters_ - kPose);
  const Eigen::Map<const Eigen::Matrix<double, kCells, kAll>> gradients(gradients_.data());
  gradient_ = gradients.topRows(rows).colwise().sum();
  sumUpBlocks(cells, pose_blocks_);
  return static_cast<int>(used_.size());
}

template <int N>
void PoseUncertainty::sumUpBlocks(const std::vector<int32_t>& cells, BlockSums<N>& blocks) const {
  blocks.clear();
  const int stride = columns_.view().size;
  const auto root = static_cast<float>(std::sqrt(bend_));
  typename BlockSums<N>::Derivatives derivatives = BlockSums<N>::Derivatives::Zero();
  for (size_t i = 0; i < used_.size(); ++i) {
    for (int k = 0; k < N; ++k) derivatives[k] = root * J_[i + static_cast<size_t>(k * stride)];
    blocks.addMatch(cells[static_cast<size_t>(used_[i])], derivatives);
  }
  using Gradient = Eigen::Map<const typename BlockSums<N>::Parameters, 0, Eigen::InnerStride<kCells>>;
  for (int cell = 0; cell < kCells; ++cell) {
    const int cluster = cluster_of_[static_cast<size_t>(cell)];
    if (cluster >= 0) blocks.addCell(cell, Gradient(gradients_.data() + cluster));
  }
}

PoseBreak PoseUncertainty::findBreak(const std::vector<int32_t>& cells, const Information& extended_inverse) {
  constexpr size_t kSpans = PoseBreak::kSide * (PoseBreak::kSide + 1) / 2;
  suspects_.reserve(kSpans * kSpans);
  // Without the camera's parameters first, which takes a tenth of the time and mostly settles it.
  pose_blocks_.findSuspects(scatter_.topLeftCorner<kPose, kPose>(), gradient_.head<kPose>(), suspects_);
  if (suspects_.empty()) return {};
  sumUpBlocks(cells, all_blocks_);
  return all_blocks_.worstOf(suspects_, extended_inverse, scatter_, gradient_);
}

PoseSpread PoseUncertainty::measure(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
                                    const std::vector<int32_t>& cells, double calibration_sigma) {
  PoseSpread spread;
  if (sumUp(points, pose, noise, cells) < kAll) return spread;
  const double variance = noise.sigma() * noise.sigma();
  const PoseSquare seeming = inverseOf(curvature_.topLeftCorner<kPose, kPose>()),
                   inverse = inverseOf(information(variance));
  if (!seeming.allFinite() || !inverse.allFinite()) return spread;
  // Huber's sandwich, clustered (Liang & Zeger 1986): noise of one neighbourhood may be common to it. The pose may lie
  // beside the optimum where nothing refined it.
  const auto sandwich = [&](const PoseSquare& bread, const PoseSquare& scatter) -> PoseSquare {
    const Pose step = bread * gradient_.head<kPose>();
    return bread * scatter * bread + step * step.transpose();
  };
  spread.sandwich = sandwich(seeming, scatter_.topLeftCorner<kPose, kPose>());
  const PoseSquare scatter = scatterWithoutLeverage(cells, seeming), seeming_sandwich = sandwich(seeming, scatter);
  const Pose scale = widening(seeming_sandwich, seeming * gradient_.head<kPose>());
  const auto widened = [&](const PoseSquare& covariance) -> PoseSquare {
    return scale.asDiagonal() * covariance * scale.asDiagonal();
  };
  spread.covariance = spread.of_matches = widened(sandwich(inverse, scatter));
  const CameraScores camera = cameraScores(inverse);
  const CameraContradiction contradiction = testCamera(camera);
  spread.contradiction = contradiction.statistic;
  spread.contradicted = contradiction.parameter;
  spread.camera_errors = cameraErrors(camera, pose);
  const Eigen::Matrix<double, kPose, kUnmodelledCount> by_camera =
      seeming * curvature_.block<kPose, kUnmodelledCount>(0, kPose);
  spread.covariance += by_camera * cameraError(cameraScores(seeming)) * by_camera.transpose();
  const Information extended_inverse = extendedInverse(variance);
  spread.pose_break = findBreak(cells, extended_inverse);
  spread.of_any_camera = extendedCovariance(extended_inverse, variance);
  const double doubt = std::clamp((spread.contradiction - kFirstDoubt) / (kFullDoubt - kFirstDoubt), 0.0, 1.0);
  if (doubt > 0) spread.sandwich += doubt * (spread.of_any_camera - spread.sandwich);
  const Eigen::Matrix<double, kPose, 3> effect = calibration_sigma * inverse * curvature_.block<kPose, 3>(0, kPose);
  for (auto* covariance : {&spread.covariance, &spread.of_any_camera, &spread.sandwich}) {
    *covariance += effect * effect.transpose();
    if (!isCovariance(*covariance)) covariance->setIdentity();
  }
  return spread;
}

PoseSquare PoseUncertainty::information(double variance) const {
  const PointColumnsView used = columns_.view();
  const Eigen::Map<const Eigen::VectorXf> first(turns_.data(), used.count),
      second(turns_.data() + used.size, used.count);
  Eigen::Matrix2d noise;
  noise << first.dot(first), first.dot(second), second.dot(first), second.dot(second);
  noise *= bend_ * variance;
  // What is told of the direction with the rotation unknown.
  PoseSquare told = curvature_.topLeftCorner<kPose, kPose>();
  auto of_direction = told.bottomRightCorner<2, 2>();
  const Eigen::Matrix<double, 3, 2> shared = told.topRightCorner<3, 2>();
  const Eigen::Matrix2d alone = of_direction - shared.transpose() * told.topLeftCorner<3, 3>().ldlt().solve(shared);
  const double share =
      Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d>(noise, alone, Eigen::EigenvaluesOnly).eigenvalues()[1];
  if (share > 0) of_direction -= std::min(1.0, kMostNoise / share) * noise;
  return told;
}

size_t PoseUncertainty::clusterOf(const std::vector<int32_t>& cells, int used) const {
  return static_cast<size_t>(
      cluster_of_[static_cast<size_t>(cells[static_cast<size_t>(used_[static_cast<size_t>(used)])])]);
}

std::array<float, PoseUncertainty::kCells> PoseUncertainty::leverages(const std::vector<int32_t>& cells,
                                                                      const PoseSquare& inverse) const {
  const PointColumnsView used = columns_.view();
  const Eigen::Matrix<float, kPose, kPose> root =
      Eigen::LLT<PoseSquare>(bend_ * inverse).matrixU().toDenseMatrix().cast<float>();
  std::array<float, kCells> leverages = {};
  for (int i = 0; i < used.count; i += kLanesAtOnce) {
    Lanes leverage = Lanes::Zero();
    for (int row = 0; row < kPose; ++row) {
      Lanes entry = Lanes::Zero();
      for (int k = row; k < kPose; ++k) entry += root(row, k) * lanes(J_.data() + k * used.size + i);
      leverage += entry * entry;
    }
    for (int lane = 0; lane < std::min(kLanesAtOnce, used.count - i); ++lane) {
      leverages[clusterOf(cells, i + lane)] += leverage[lane];
    }
  }
  return leverages;
}

PoseSquare PoseUncertainty::curvatureOf(size_t cluster, const std::vector<int32_t>& cells) const {
  const PointColumnsView used = columns_.view();
  PoseSquare curvature = PoseSquare::Zero();
  for (int i = 0; i < used.count; ++i) {
    if (clusterOf(cells, i) != cluster) continue;
    Pose derivatives;
    for (int k = 0; k < kPose; ++k) derivatives[k] = static_cast<double>(J_.data()[k * used.size + i]);
    curvature += bend_ * derivatives * derivatives.transpose();
  }
  return curvature;
}

PoseSquare PoseUncertainty::scatterWithoutLeverage(const std::vector<int32_t>& cells, const PoseSquare& inverse) const {
  const std::array<float, kCells> leverage = leverages(cells, inverse);
  PoseSquare scatter = scatter_.topLeftCorner<kPose, kPose>();
  for (size_t cluster = 0; cluster < static_cast<size_t>(clusters_); ++cluster) {
    if (!(leverage[cluster] > kHighLeverage)) continue;
    const Pose gradient = Eigen::Map<const Pose, 0, Eigen::InnerStride<kCells>>(gradients_.data() + cluster);
    const PoseSquare kept = PoseSquare::Identity() - curvatureOf(cluster, cells) * inverse;
    const Pose without = kept.partialPivLu().solve(gradient);
    scatter += without * without.transpose() - gradient * gradient.transpose();
  }
  return scatter;
}

PoseUncertainty::Pose PoseUncertainty::widening(const PoseSquare& sandwich, const Pose& step) const {
  if (clusters_ >= kEnoughCells) return Pose::Ones();
  const PoseSquare others = pose_blocks_.jackknife(curvature_.topLeftCorner<kPose, kPose>(), step);
  const auto of = [&](int first, int count) {
    return std::sqrt(
        std::max(1., others.diagonal().segment(first, count).sum() / sandwich.diagonal().segment(first, count).sum()));
  };
  Pose scale;
  scale << Eigen::Vector3d::Constant(of(0, 3)), Eigen::Vector2d::Constant(of(3, 2));
  return scale;
}

CameraScores PoseUncertainty::cameraScores(const PoseSquare& inverse) const {
  Eigen::Matrix<double, kUnmodelledCount, kAll> unexplained;
  unexplained << -curvature_.bottomLeftCorner<kUnmodelledCount, kPose>() * inverse, CameraSquare::Identity();
  return {unexplained * gradient_, unexplained * curvature_.rightCols<kUnmodelledCount>(),
          unexplained * scatter_ * unexplained.transpose()};
}

PoseUncertainty::Information PoseUncertainty::extendedInverse(double variance) const {
  const CameraParameters& sigma = unmodelledSigma();
  Information information = curvature_;
  for (int i = 0; i < kUnmodelledCount; ++i) information(kPose + i, kPose + i) += variance / (sigma[i] * sigma[i]);
  return information.ldlt().solve(Information::Identity());
}

PoseSquare PoseUncertainty::extendedCovariance(const Information& extended_inverse, double variance) const {
  const CameraParameters& sigma = unmodelledSigma();
  Information scatter = scatter_;
  for (int i = 0; i < kUnmodelledCount; ++i) {
    scatter(kPose + i, kPose + i) += variance * variance / (sigma[i] * sigma[i]);
  }
  const Pose step = (extended_inverse * gradient_).head<kPose>();
  return (extended_inverse * scatter * extended_inverse).topLeftCorner<kPose, kPose>() + step * step.transpose();
}

Eigen::Matrix<double, 6, 6> relativeCovariance(const TwoViewPose& pose, const PoseSquare& covariance) {
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
