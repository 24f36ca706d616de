#include "judgement/camera_test.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kFocalError = 0.03, kPrincipalError = 0.01, kRadialError = 0.03, kReadoutError = 2 * kDegree;

/// Parameters that err together, and the 99 % point of chi-square with as many degrees of freedom.
struct Group {
  CameraParameter parameter;
  int first, count;
  double limit;
};
constexpr int kFirst = kPoseParameters;
constexpr std::array<Group, 4> kGroups = {
    {{CameraParameter::kFocalLength, DerivativeColumn::kFocalLength - kFirst, 1, 6.63},
     {CameraParameter::kPrincipalPoint, DerivativeColumn::kPrincipalPoint - kFirst, 2, 9.21},
     {CameraParameter::kRadialDistortion, DerivativeColumn::kRadialDistortion - kFirst, 1, 6.63},
     {CameraParameter::kRollingShutter, DerivativeColumn::kRowsReference - kFirst, 6, 16.81}}};
/// A model for each set of groups that err, as bits; the last has all of them.
constexpr unsigned kModels = 1u << kGroups.size(), kAllErr = kModels - 1;

/// Share of contradictions whose cause is none of the groups alone.
constexpr double kOtherCause = 0.1;
/// Added to a scatter, of its diagonal: two views tell seven things of a motion and a pinhole camera, which have eight
/// parameters, so that focal length and principal point together leave it singular.
constexpr double kRounding = 1e-6;

/// Parameters of a group. The size is bounded, so nothing is allocated.
using SomeVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kCameraParameters, 1>;
using SomeSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kCameraParameters, kCameraParameters>;

/// Derivatives of half the loss by the camera's parameters, less what a step of the pose explains of them.
struct Scores {
  CameraVector score;
  CameraSquare information, scatter;
};

Scores scoresOf(const PoseInformation& all, const PoseSquare& inverse) {
  const Eigen::Matrix<double, kCameraParameters, kPoseParameters> by_pose =
      -all.curvature.bottomLeftCorner<kCameraParameters, kPoseParameters>() * inverse;
  Eigen::Matrix<double, kCameraParameters, kParameters> unexplained;
  unexplained << by_pose, CameraSquare::Identity();
  const Eigen::Matrix<double, kCameraParameters, kParameters> scattered = unexplained.lazyProduct(all.scatter);
  return {unexplained * all.gradient, unexplained.lazyProduct(all.curvature.rightCols<kCameraParameters>()),
          scattered.lazyProduct(unexplained.transpose())};
}

/// The model in which some groups have their typical errors, by the scores. Parameters of the other groups are zero.
struct Model {
  double log_factor = 0;  ///< logarithm of the Bayes factor against the model without errors
  CameraSquare second_moment = CameraSquare::Zero();

  Model() = default;
  Model(unsigned groups, const Scores& scores) {
    CameraVector errs = CameraVector::Zero();
    for (size_t k = 0; k < kGroups.size(); ++k) {
      if (groups >> k & 1) errs.segment(kGroups[k].first, kGroups[k].count).setOnes();
    }
    const CameraVector sigma = errs.cwiseProduct(typicalCameraError());
    CameraSquare scatter = errs.asDiagonal() * scores.scatter * errs.asDiagonal();
    scatter.diagonal() = scatter.diagonal() * (1 + kRounding) + CameraVector::Ones() - errs;
    const Eigen::LLT<CameraSquare> factors(scatter);
    if (factors.info() != Eigen::Success) return;
    const CameraVector score = factors.matrixL().solve(errs.cwiseProduct(scores.score));
    const CameraSquare effect =
        factors.matrixL().solve(CameraSquare(errs.asDiagonal() * scores.information * sigma.asDiagonal()));
    CameraSquare information = effect.transpose().lazyProduct(effect);
    information.diagonal().array() += 1;
    const Eigen::LLT<CameraSquare> posterior(information);
    const CameraVector told = effect.transpose() * score, mean = posterior.solve(told);
    log_factor = 0.5 * told.dot(mean) - posterior.matrixLLT().diagonal().array().log().sum();
    if (!std::isfinite(log_factor)) {
      log_factor = 0;
      return;
    }
    const CameraSquare moment = posterior.solve(CameraSquare::Identity()) + mean * mean.transpose();
    second_moment = sigma.asDiagonal() * moment * sigma.asDiagonal();
  }
};

/// One step of Newton's from each error alone to the optimum, and its variance by the scatter.
CameraErrors errorsOf(const Scores& scores, const TwoViewPose& pose) {
  // Correction of the parameters for an error of 1.
  Eigen::Matrix<double, kCameraParameters, CameraErrors::kCount> correction;
  correction.setZero();
  correction(0, CameraErrors::kFocalLength) = -1;
  correction(1, CameraErrors::kPrincipalX) = -1;
  correction(2, CameraErrors::kPrincipalY) = -1;
  correction(3, CameraErrors::kRadial) = 1;  // undistorting goes the other way
  const Eigen::Vector3d rotation = rotationVector(pose.R);
  correction.col(CameraErrors::kReadoutRotation).tail<6>() << rotation, rotation;
  CameraErrors errors;
  for (size_t k = 0; k < CameraErrors::kCount; ++k) {
    const CameraVector direction = correction.col(static_cast<int>(k));
    const double told = direction.dot(scores.information * direction), value = -direction.dot(scores.score) / told;
    const double inverse_variance = told * told / direction.dot(scores.scatter * direction);
    if (!std::isfinite(value) || !std::isfinite(inverse_variance)) continue;
    errors.value[k] = value;
    errors.information[k] = inverse_variance;
  }
  return errors;
}

}  // namespace

const CameraVector& typicalCameraError() {
  static const CameraVector sigma =
      (CameraVector() << kFocalError, kPrincipalError, kPrincipalError, kRadialError, kReadoutError, kReadoutError,
       kReadoutError, kReadoutError, kReadoutError, kReadoutError)
          .finished();
  return sigma;
}

CameraTest testCamera(const PoseInformation& all, const PoseSquare& inverse, const PoseSquare& naive,
                      const TwoViewPose& pose) {
  const Scores scores = scoresOf(all, inverse), naive_scores = scoresOf(all, naive);
  CameraTest test;
  test.errors = errorsOf(scores, pose);
  // Rao's score test of each group.
  for (const Group& group : kGroups) {
    const SomeVector part = scores.score.segment(group.first, group.count);
    const SomeSquare block = scores.scatter.block(group.first, group.first, group.count, group.count);
    const double statistic = part.dot(block.ldlt().solve(part)) / group.limit;
    if (!(statistic > test.statistic) || !std::isfinite(statistic)) continue;  // a scatter may be singular
    test.statistic = statistic;
    test.parameter = group.parameter;
  }
  std::array<Model, kModels> models;
  double largest = 0;
  for (unsigned groups = 1; groups < kModels; ++groups) {
    models[groups] = Model(groups, naive_scores);
    largest = std::max(largest, models[groups].log_factor);
  }
  // Average over the models (Hoeting et al. 1999), each weighed by how much its factor exceeds one: what the scores do
  // not tell from no error is none. Factors are in units of the largest, so that none overflows.
  const double none = std::exp(-largest);
  double err = 0;
  for (const Model& model : models) {
    const double weight = std::max(0., std::exp(model.log_factor - largest) - none);
    test.second_moment += (1 - kOtherCause) * weight * model.second_moment;
    err += weight;
  }
  test.second_moment += kOtherCause * err * models[kAllErr].second_moment;
  test.second_moment /= none + err;
  return test;
}

}  // namespace gms_ransac
