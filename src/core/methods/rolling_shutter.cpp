#include "methods/rolling_shutter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "judgement/candidates.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

namespace {

using Eigen::Vector3d;

/// Pixels by which a rotation must move points to need another estimate.
constexpr double kLeastMoved = 0.1;
/// Standard deviations above zero from which on a learnt readout is corrected for; the next pairs show the rest.
constexpr double kKnown = 2;
/// Share of a rotation's published variance that other pairs do not have, too.
constexpr double kOfThePair = 0.3;
/// Each pass leaves a tenth of the error in the rotation.
constexpr int kMostPasses = 3;
/// Vuong's statistic: the moved points fit so much worse that rotation or readout must be wrong.
constexpr double kContradicted = -2;
/// Vuong's statistic: they fit so much better that it must be right.
constexpr double kConfirmed = 2;
/// Threshold of a transfer distance, which has the noise of two images.
constexpr double kTransferThreshold = 2;
/// Chi-square with three degrees of freedom exceeds it in 1 % of cases.
constexpr double kAgrees = 11.34;

void moveImage(const std::vector<float>& image_row, int height, const Camera& camera, double readout,
               const Vector3d& rate, std::vector<float>& x, std::vector<float>& y) {
  const CameraIntrinsics& k = camera.pinhole();
  const double last = std::max(1, height - 1);
  for (size_t row = 0; row < x.size(); ++row) {
    const double pixel_row = static_cast<double>(image_row.size() == x.size() ? image_row[row] : y[row]);
    const Vector3d rotation = readout * (pixel_row / last - 0.5) * rate;
    const Vector3d ray((static_cast<double>(x[row]) - k.cx) / k.fx, (static_cast<double>(y[row]) - k.cy) / k.fy, 1);
    // To second order: the third moves a point by 0.01 px for three degrees.
    const Vector3d step = rotation.cross(ray), moved = ray + step + 0.5 * rotation.cross(step);
    if (!(moved.z() > 0)) {  // rotated behind the image plane: no coordinates
      x[row] = y[row] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    x[row] = static_cast<float>(k.fx * moved.x() / moved.z() + k.cx);
    y[row] = static_cast<float>(k.fy * moved.y() / moved.z() + k.cy);
  }
}

/// Stretch of the rows, and of the noise, in the middle of the image.
double stretch(const Camera& camera, double readout, const Vector3d& rate, int height) {
  return 1 - camera.pinhole().fy * readout * rate.x() / std::max(1, height - 1);
}

/// Rates of rotation at both images, which change evenly from the pair before to this one, unless the change is noise.
RotationRates ratesOf(const PointPairs& pairs, const RelativePose& pose) {
  const Vector3d rate = rotationVector(pose.R) / *pairs.seconds;
  if (!pairs.velocity_before) return {rate, rate};
  const Vector3d change = rate - pairs.velocity_before->value;
  const double noise = pose.covariance.bottomRightCorner<3, 3>().trace() / (*pairs.seconds * *pairs.seconds) +
                       pairs.velocity_before->variance;
  // Shrunk as by James and Stein (1961).
  const Vector3d half = 0.5 * std::max(0., 1 - kOfThePair * noise / std::max(1e-12, change.squaredNorm())) * change;
  return {rate - half, rate + half};
}

/// True if the other sensor's rotation may be that of the images.
bool agree(const RotationPrior& prior, const RobustResult& seen) {
  if (!seen.judgement.pose_found) return false;
  const Vector3d apart = rotationVector(prior.R * seen.judgement.pose.R.transpose());
  const Eigen::Matrix3d covariance = prior.covariance + seen.judgement.pose.covariance.bottomRightCorner<3, 3>();
  return apart.dot(covariance.ldlt().solve(apart)) < kAgrees;
}

}  // namespace

void moveToMiddleRow(const PointPairs& pairs, const Camera& camera, double readout, const RotationRates& rates,
                     PointPairs& moved) {
  moved = pairs;
  moveImage(pairs.row_reference, pairs.image_reference.height, camera, readout, rates.reference, moved.x_reference,
            moved.y_reference);
  moveImage(pairs.row_current, pairs.image_current.height, camera, readout, rates.current, moved.x_current,
            moved.y_current);
}

RollingShutter::RollingShutter(std::unique_ptr<Method> method, const RobustOptions& options)
    : method_(std::move(method)), given_(options.rolling_shutter_readout), threshold_px_(options.inlierThreshold()) {}

void RollingShutter::estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  method_->estimate(pairs, camera, result);
  readout_ = camera.calibrated() ? readoutOf(pairs, camera) : 0;
  if (readout_ == 0) return;
  costs_.model.clear();
  correctByPair(pairs, camera, result);
  correctByPrior(pairs, camera, result);
  if (result.row_correction == RowCorrection::kPair || result.row_correction == RowCorrection::kPrior) {
    result.readout = readout_ * camera.pinhole().fy / std::max(1, pairs.image_current.height);
  }
}

void RollingShutter::correctByPair(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  // A camera reads one image before the next.
  if (!(std::abs(pairs.seconds.value_or(0)) >= readout_)) {
    if (given_ > 0) result.row_correction = RowCorrection::kUnknownTime;
    return;
  }
  RotationRates rates;
  for (int pass = 0; pass < kMostPasses && result.judgement.pose_found; ++pass) {
    const RotationRates shown = ratesOf(pairs, result.judgement.pose);
    if (moves(shown.reference - rates.reference, camera) < kLeastMoved &&
        moves(shown.current - rates.current, camera) < kLeastMoved) {
      return;
    }
    rates = shown;
    if (tryMoved(pairs, camera, rates, result) < kContradicted) {
      if (pass == 0) result.row_correction = RowCorrection::kUnlikely;
      return;
    }
    accept(RowCorrection::kPair, result);
  }
}

void RollingShutter::correctByPrior(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  if (!pairs.rotation_prior || !pairs.rotation_prior->rates) return;
  const RotationPrior& prior = *pairs.rotation_prior;
  if (std::max(moves(prior.rates->reference, camera), moves(prior.rates->current, camera)) < kLeastMoved) return;
  const double better = tryMoved(pairs, camera, *prior.rates, result);
  // Where the matches cannot tell, the prior's rotation must agree with the images'.
  if (better > kConfirmed || (better > kContradicted && agree(prior, result))) accept(RowCorrection::kPrior, result);
}

double RollingShutter::tryMoved(const PointPairs& pairs, const Camera& camera, const RotationRates& rates,
                                RobustResult& result) {
  constexpr double kCertain = std::numeric_limits<double>::infinity();
  if (costs_.model.empty()) weigh(pairs, camera, {}, result, costs_);
  moveToMiddleRow(pairs, camera, readout_, rates, moved_);
  moved_.previous_motion = result.optimum;
  method_->estimate(moved_, camera, candidate_);
  result.effort += candidate_.effort;
  if (result.judgement.pose_found != candidate_.judgement.pose_found)
    return candidate_.judgement.pose_found ? kCertain : -kCertain;
  weigh(moved_, camera, rates, candidate_, candidate_costs_);
  cells_.resize(static_cast<size_t>(pairs.size()));
  for (size_t row = 0; row < cells_.size(); ++row) {
    cells_[row] = spreadCell({pairs.x_reference[row], pairs.y_reference[row]}, pairs.image_reference);
  }
  // Without observable translation a model with one absorbs the effect of the rows: compare rotations alone.
  const auto costs = result.judgement.translation_observable || candidate_.judgement.translation_observable
                         ? &Costs::model
                         : &Costs::rotation;
  return vuongStatistic(pairs.size(), cells_,
                        [&](size_t row) { return (costs_.*costs)[row] - (candidate_costs_.*costs)[row]; });
}

void RollingShutter::accept(RowCorrection correction, RobustResult& result) {
  candidate_.effort = result.effort;
  candidate_.row_correction = correction;
  std::swap(result, candidate_);
  std::swap(costs_, candidate_costs_);
}

void RollingShutter::weigh(const PointPairs& pairs, const Camera& camera, const RotationRates& rates,
                           const RobustResult& result, Costs& costs) const {
  const double stretch_reference = stretch(camera, readout_, rates.reference, pairs.image_reference.height);
  const double stretch_current = stretch(camera, readout_, rates.current, pairs.image_current.height);
  const auto fill = [&](ModelType type, const Eigen::Matrix3d& model, double threshold, std::vector<float>& column) {
    const FinalResidual residual(camera, type, model, stretch_reference, stretch_current);
    residual.forEach(pairs, [&](size_t row, double squared) {
      const double cost = pairs.hasCoordinates(row) ? squared / (threshold * threshold) : 1;
      if (cost < 1) column[row] = static_cast<float>(cost);
    });
  };
  for (auto* column : {&costs.model, &costs.rotation}) column->assign(static_cast<size_t>(pairs.size()), 1.f);
  if (!result.judgement.pose_found) return;
  const Eigen::Matrix3d K = camera.K();
  fill(result.model_type, result.model, threshold_px_, costs.model);
  fill(ModelType::kHomography, K * result.judgement.rotation_alone.transpose() * K.inverse(),
       kTransferThreshold * threshold_px_, costs.rotation);
}

double RollingShutter::readoutOf(const PointPairs& pairs, const Camera& camera) const {
  const Shutter& learnt = pairs.shutter;
  if (given_ > 0) return given_;
  if (learnt.kind == Shutter::kGlobal || learnt.readout < kKnown * learnt.deviation) return 0;
  return learnt.readout * pairs.image_current.height / camera.pinhole().fy;
}

double RollingShutter::moves(const Vector3d& rate, const Camera& camera) const {
  return 0.5 * readout_ * rate.norm() * camera.meanFocalLength();
}

}  // namespace gms_ransac
