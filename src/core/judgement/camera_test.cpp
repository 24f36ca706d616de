#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "judgement/pose_covariance.h"

namespace gms_ransac {

namespace {

/// Parameters that err together, and the 99 % point of chi-square with as many degrees of freedom.
struct Group {
  CameraParameter parameter;
  int first, count;
  double limit;
};
constexpr std::array<Group, 4> kGroups = {
    {{CameraParameter::kFocalLength, DerivativeColumn::kFocalLength - kPoseParameters, 1, 6.63},
     {CameraParameter::kPrincipalPoint, DerivativeColumn::kPrincipalPoint - kPoseParameters, 2, 9.21},
     {CameraParameter::kRadialDistortion, DerivativeColumn::kRadialDistortion - kPoseParameters, 1, 6.63},
     {CameraParameter::kRollingShutter, DerivativeColumn::kRowsReference - kPoseParameters, 6, 16.81}}};
/// Share of contradictions whose cause is none of the groups alone.
constexpr double kOtherCause = 0.1;
/// Added to a scatter, of its diagonal: two views tell seven things of a motion and a pinhole camera, which have eight
/// parameters, so that focal length and principal point together leave it singular.
constexpr double kRounding = 1e-6;

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

/// The model in which some groups have their typical errors: their scores have the scatter and, on average, the effect
/// of these errors.
struct Model {
  double statistic = 0;   ///< of Rao's test that none of the groups errs
  double log_factor = 0;  ///< logarithm of the Bayes factor against the model without errors

  Model() = default;
  Model(unsigned groups, const Scores& scores) {
    for (size_t k = 0; k < kGroups.size(); ++k) {
      for (int i = 0; i < kGroups[k].count && groups >> k & 1; ++i) parameters_[size_++] = kGroups[k].first + i;
    }
    SomeVector score(size_);
    SomeSquare scatter(size_, size_);
    effect_.resize(size_, size_);
    for (int i = 0; i < size_; ++i) {
      score[i] = scores.score[parameters_[i]];
      for (int j = 0; j < size_; ++j) {
        scatter(i, j) = scores.scatter(parameters_[i], parameters_[j]);
        effect_(i, j) = scores.information(parameters_[i], parameters_[j]) * typicalCameraError()[parameters_[j]];
      }
      scatter(i, i) *= 1 + kRounding;
    }
    const Eigen::LLT<SomeSquare> chance(scatter);
    scatter += effect_.lazyProduct(effect_.transpose());
    both_.compute(scatter);
    if (chance.info() != Eigen::Success || both_.info() != Eigen::Success) return;
    const SomeVector weighed = both_.solve(score);
    const double told = chance.matrixL().solve(score).squaredNorm();
    const auto ratio = both_.matrixLLT().diagonal().array() / chance.matrixLLT().diagonal().array();
    const double factor = 0.5 * (told - score.dot(weighed)) - ratio.log().sum();
    if (!std::isfinite(factor)) return;
    weighed_ = weighed;
    statistic = told;
    log_factor = factor;
  }
  /// Adds the second moment of the errors, times a weight.
  void addMoment(double weight, CameraSquare& sum) const {
    if (!(weight > 0) || weighed_.size() == 0) return;
    const SomeSquare told = both_.matrixL().solve(effect_);
    const SomeVector mean = effect_.transpose() * weighed_;
    SomeSquare moment = mean * mean.transpose() - told.transpose().lazyProduct(told);
    moment.diagonal().array() += 1;
    for (int i = 0; i < size_; ++i) {
      for (int j = 0; j < size_; ++j) {
        const double sigmas = typicalCameraError()[parameters_[i]] * typicalCameraError()[parameters_[j]];
        sum(parameters_[i], parameters_[j]) += weight * sigmas * moment(i, j);
      }
    }
  }

 private:
  // Rows and columns are the parameters that err. The size is bounded, so nothing is allocated.
  using SomeVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kCameraParameters, 1>;
  using SomeSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kCameraParameters, kCameraParameters>;

  int size_ = 0;
  int parameters_[kCameraParameters] = {};
  SomeSquare effect_;            ///< of typical errors on the scores
  Eigen::LLT<SomeSquare> both_;  ///< of the scores' covariance by chance and by the errors
  SomeVector weighed_;           ///< the scores by its inverse; empty where they tell nothing of these errors
};

/// Scores of the rates by row, weighed by their scatter; zero where that is singular.
RowRates rowRatesOf(const Scores& scores) {
  constexpr int kFirst = DerivativeColumn::kRowsReference - kPoseParameters, kCount = 6;
  using Square = Eigen::Matrix<double, kCount, kCount>;
  Square scatter = scores.scatter.block<kCount, kCount>(kFirst, kFirst);
  scatter.diagonal() *= 1 + kRounding;
  const Square information = scores.information.block<kCount, kCount>(kFirst, kFirst);
  const Eigen::LLT<Square> factors(scatter);
  RowRates rates;
  if (factors.info() != Eigen::Success) return rates;
  const Eigen::Matrix<double, kCount, 1> score = factors.solve(scores.score.segment<kCount>(kFirst));
  Eigen::Map<Eigen::Matrix<double, kCount, 1>>(rates.score.data()) = information * score;
  Eigen::Map<Square>(rates.information.data()) = information * factors.solve(information);
  return rates;
}

}  // namespace

CameraTest testCamera(const PoseInformation& all, const PoseSquare& inverse) {
  const Scores scores = scoresOf(all, inverse);
  CameraTest test;
  test.rates = rowRatesOf(scores);
  std::array<Model, 1u << kGroups.size()> models;  // one for each set of groups that err, as bits
  double largest = 0;
  for (unsigned groups = 1; groups < models.size(); ++groups) {
    models[groups] = Model(groups, scores);
    largest = std::max(largest, models[groups].log_factor);
  }
  for (size_t k = 0; k < kGroups.size(); ++k) {
    const double statistic = models[1u << k].statistic / kGroups[k].limit;
    if (statistic <= test.statistic) continue;
    test.statistic = statistic;
    test.parameter = kGroups[k].parameter;
  }
  // Average over the models (Hoeting et al. 1999), each weighed by how much its factor exceeds one: what the scores do
  // not tell from no error is none. Factors are in units of the largest, so that none overflows.
  const double none = std::exp(-largest);
  double err = 0;
  for (const Model& model : models) {
    const double weight = std::max(0., std::exp(model.log_factor - largest) - none);
    model.addMoment((1 - kOtherCause) * weight, test.second_moment);
    err += weight;
  }
  models.back().addMoment(kOtherCause * err, test.second_moment);
  test.second_moment /= none + err;
  return test;
}

}  // namespace gms_ransac
