#include "methods/optima.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "ransac/proposals.h"
#include "support/order_statistics.h"

namespace gms_ransac {

namespace {

/// Steps on a random part of the matches, after which optima can be compared. The other motion of a plane is calculated
/// and not found, so it is further from its optimum.
constexpr int kPartIterations = 3, kPlaneIterations = 6;
constexpr float kMedianOfSquare = 0.455f;  ///< of a standard normal variable's
constexpr float kMostCost = 9;             ///< of a wrong match: three standard deviations

}  // namespace

TwoViewPose Optima::choose(const TwoViewPoints& points, const TwoViewPose& found,
                           const std::vector<TwoViewPose>& starts) {
  const PoseModel model(kernels_, points.view()), part = model.first(kRandomPart);
  measure(part, found);
  propose(model, found, starts);
  alternatives.clear();
  for (const TwoViewPose& start : starts) alternatives.push_back({start});
  for (Optimum& optimum : optima_) {
    part.refine(kRobustLoss, optimum.of_plane ? kPlaneIterations : kPartIterations, optimum.pose);
    optimum.pose = part.withBetterSign(optimum.pose, optimum.cost);
    optimum.cost = costOf(part, optimum.pose);
    if (!optimum.of_plane) continue;
    alternatives.push_back({found, true});
    alternatives.push_back({optimum.pose, true});
  }
  const auto cheaper = [](const Optimum& a, const Optimum& b) { return a.cost < b.cost; };
  TwoViewPose best = std::min_element(optima_.begin(), optima_.end(), cheaper)->pose;
  if (!(costOf(part, best) < costOf(part, found))) return found;
  model.refine(kRobustLoss, kFinalIterations, best, kEnough);
  if (!(costOf(model, best) < costOf(model, found))) return found;
  alternatives.push_back({found});
  return best;
}

void Optima::measure(const PoseModel& model, const TwoViewPose& found) {
  const auto count = static_cast<size_t>(model.points().count);
  model.residualsInFront(found, residuals_);
  model.rotationResiduals(found.R, parallaxes_);
  const auto medianOfInliers = [&](const std::vector<float>& values) {
    sorted_.clear();
    for (size_t slot = 0; slot < count; ++slot) {
      if (residuals_[slot] < 1) sorted_.push_back(values[slot]);
    }
    return sorted_.empty() ? 1 : nthSmallest(sorted_, sorted_.size() / 2);
  };
  median_parallax_ = medianOfInliers(parallaxes_);
  per_variance_ = kMedianOfSquare / std::max(medianOfInliers(residuals_), std::numeric_limits<float>::min());
}

void Optima::propose(const PoseModel& model, const TwoViewPose& found, const std::vector<TwoViewPose>& starts) {
  optima_.clear();
  for (const TwoViewPose& start : starts) optima_.push_back({start, false, 0});
  far_.copy(firstSlots(model.points(), kRandomPart),
            [this](int slot) { return parallaxes_[static_cast<size_t>(slot)] <= median_parallax_; });
  TwoViewPose of_far = found;
  PoseModel(kernels_, far_.view()).refine(kRobustLoss, kPartIterations, of_far);
  optima_.push_back({of_far, false, 0});
  if (const auto other = findOtherPlaneMotion(model, found, residuals_)) optima_.push_back({*other, true, 0});
}

float Optima::costOf(const PoseModel& model, const TwoViewPose& pose) {
  model.residualsInFront(pose, residuals_);
  float sum = 0;
  for (int slot = 0; slot < model.points().count; ++slot) {
    sum += std::min(per_variance_ * residuals_[static_cast<size_t>(slot)], kMostCost);
  }
  return sum;
}

}  // namespace gms_ransac
