#include "judgement/camera_doubt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kRowsSigma = 2 * kDegree;

/// Parameters that are off together, and what chi-square with as many degrees of freedom exceeds in 1 % of cases.
struct Group {
  CameraParameter parameter;
  Unmodelled::Parameter first;
  int count;
  double limit;
};
constexpr std::array<Group, 4> kGroups = {{{CameraParameter::kFocalLength, Unmodelled::kFocalLength, 1, 6.63},
                                           {CameraParameter::kPrincipalPoint, Unmodelled::kPrincipalPoint, 2, 9.21},
                                           {CameraParameter::kRadialDistortion, Unmodelled::kRadialDistortion, 1, 6.63},
                                           {CameraParameter::kRollingShutter, Unmodelled::kRowsReference, 6, 16.81}}};
/// One for each set of groups that are off, as bits; the last has all of them.
constexpr unsigned kModels = 1u << kGroups.size(), kAllOff = kModels - 1;

/// Share of contradictions whose cause is none of the groups alone (doc/uncertainty.md).
constexpr double kOtherCause = 0.1;
/// Added to a scatter, of its diagonal: two views tell seven things of a motion and a pinhole camera, which have eight
/// parameters, so that focal length and principal point together leave it singular.
constexpr double kRounding = 1e-6;

/// Of the parameters of some groups; no more than there are, so that nothing is allocated.
using Some = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, Unmodelled::kCount, 1>;
using SomeSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Unmodelled::kCount, Unmodelled::kCount>;

/// The model in which some groups are off by their sigmas: what the scores say of it, in units of these.
class OffModel {
 public:
  /// @param groups  those that are off, as bits of places in kGroups
  OffModel(unsigned groups, const CameraScores& scores) {
    for (size_t k = 0; k < kGroups.size(); ++k) {
      if (!(groups >> k & 1)) continue;
      for (int i = 0; i < kGroups[k].count; ++i) index_[count_++] = kGroups[k].first + i;
    }
    SomeSquare scatter(count_, count_), effect(count_, count_);
    Some score(count_);
    for (int i = 0; i < count_; ++i) {
      score[i] = scores.score[index(i)];
      for (int j = 0; j < count_; ++j) {
        scatter(i, j) = scores.scatter(index(i), index(j));
        effect(i, j) = scores.information(index(i), index(j)) * unmodelledSigma()[index(j)];
      }
    }
    scatter.diagonal() *= 1 + kRounding;
    const Eigen::LLT<SomeSquare> factors(scatter);
    if (factors.info() != Eigen::Success) return;
    factors.matrixL().solveInPlace(effect);
    factors.matrixL().solveInPlace(score);
    SomeSquare information = effect.transpose() * effect;
    information.diagonal().array() += 1;
    posterior_.compute(information);
    mean_ = posterior_.solve(effect.transpose() * score);
    log_factor_ = 0.5 * (effect.transpose() * score).dot(mean_) - posterior_.matrixLLT().diagonal().array().log().sum();
    if (!std::isfinite(log_factor_)) log_factor_ = 0;
  }

  /// Logarithm of how much likelier the scores are than with no group off; 0 where they do not suffice to tell.
  double logFactor() const { return log_factor_; }

  void addMoment(double weight, CameraSquare& sum) const {
    if (mean_.size() == 0 || weight == 0) return;
    SomeSquare moment = posterior_.solve(SomeSquare::Identity(count_, count_));
    moment += mean_ * mean_.transpose();
    for (int i = 0; i < count_; ++i) {
      for (int j = 0; j < count_; ++j) {
        sum(index(i), index(j)) +=
            0.5 * weight * unmodelledSigma()[index(i)] * unmodelledSigma()[index(j)] * (moment(i, j) + moment(j, i));
      }
    }
  }

 private:
  int index(int i) const { return index_[static_cast<size_t>(i)]; }

  std::array<int, Unmodelled::kCount> index_ = {};
  int count_ = 0;
  Eigen::LLT<SomeSquare> posterior_;
  Some mean_;
  double log_factor_ = 0;
};

/// Each model, at the place that its groups are as bits. Made in place: Eigen's factors can't be moved before they are
/// computed.
template <size_t... kGroupsOff>
std::array<OffModel, sizeof...(kGroupsOff)> eachModel(const CameraScores& scores,
                                                      std::index_sequence<kGroupsOff...> /*groups*/) {
  return {{OffModel(kGroupsOff, scores)...}};
}

}  // namespace

const CameraParameters& unmodelledSigma() {
  static const CameraParameters sigma = (CameraParameters() << 0.03, 0.01, 0.01, 0.03, kRowsSigma, kRowsSigma,
                                         kRowsSigma, kRowsSigma, kRowsSigma, kRowsSigma)
                                            .finished();
  return sigma;
}

CameraContradiction testCamera(const CameraScores& scores) {
  CameraContradiction most;
  for (const Group& group : kGroups) {
    const Some part = scores.score.segment(group.first, group.count);
    const SomeSquare block = scores.scatter.block(group.first, group.first, group.count, group.count);
    const double statistic = part.dot(block.ldlt().solve(part)) / group.limit;
    if (!(statistic > most.statistic) || !std::isfinite(statistic)) continue;  // a scatter may be singular
    most = {statistic, group.parameter};
  }
  return most;
}

CameraErrors cameraErrors(const CameraScores& scores, const TwoViewPose& pose) {
  // What an error of 1 takes back of the parameters.
  Eigen::Matrix<double, Unmodelled::kCount, CameraErrors::kCount> correction =
      Eigen::Matrix<double, Unmodelled::kCount, CameraErrors::kCount>::Zero();
  correction(Unmodelled::kFocalLength, CameraErrors::kFocalLength) = -1;
  correction(Unmodelled::kPrincipalPoint, CameraErrors::kPrincipalX) = -1;
  correction(Unmodelled::kPrincipalPoint + 1, CameraErrors::kPrincipalY) = -1;
  correction(Unmodelled::kRadialDistortion, CameraErrors::kRadial) = 1;  // undistorting goes the other way
  const Eigen::Vector3d turn = rotationVector(pose.R);
  correction.block<3, 1>(Unmodelled::kRowsReference, CameraErrors::kTurnWhileRead) = turn;
  correction.block<3, 1>(Unmodelled::kRowsCurrent, CameraErrors::kTurnWhileRead) = turn;

  CameraErrors errors;
  for (size_t k = 0; k < CameraErrors::kCount; ++k) {
    const auto direction = correction.col(static_cast<int>(k));
    const double told = direction.dot(scores.information * direction), value = -direction.dot(scores.score) / told;
    const double inverse_variance = told * told / direction.dot(scores.scatter * direction);
    if (!std::isfinite(value) || !std::isfinite(inverse_variance)) continue;
    errors.value[k] = value;
    errors.information[k] = inverse_variance;
  }
  return errors;
}

CameraSquare cameraError(const CameraScores& scores) {
  // Factors in units of the largest, so that none overflows.
  const auto models = eachModel(scores, std::make_index_sequence<kModels>());
  double largest = 0;
  for (const OffModel& model : models) largest = std::max(largest, model.logFactor());
  CameraSquare moment = CameraSquare::Zero();
  const double none = std::exp(-largest);
  double off = 0;
  for (unsigned groups = 1; groups < kModels; ++groups) {
    // What the scores do not tell from none is none.
    const double weight = std::max(0., std::exp(models[groups].logFactor() - largest) - none);
    off += weight;
    models[groups].addMoment((1 - kOtherCause) * weight, moment);
  }
  models[kAllOff].addMoment(kOtherCause * off, moment);
  return moment / (none + off);
}

}  // namespace gms_ransac
