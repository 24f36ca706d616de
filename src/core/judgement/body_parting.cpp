#include "judgement/body_parting.h"

#include <algorithm>
#include <utility>

namespace gms_ransac {

namespace {

constexpr int kRounds = 4;  ///< in most scenes the third changes nothing
constexpr int kIterations = 10;
/// Of the cost of one pose: what two motions must get below. Two that are fitted to one by chance come to 0.9.
constexpr double kMostCost = 0.9;

}  // namespace

void BodyParting::part(const ResidualKernels& kernels, const PointColumnsView& points,
                       const std::vector<int32_t>& cells, const PoseBreak& pose_break,
                       const std::vector<float>& residuals, TwoViewPose& pose, int64_t& evaluations) {
  apart_.resize(static_cast<size_t>(points.count));
  for (size_t i = 0; i < apart_.size(); ++i) apart_[i] = pose_break.holds(cells[i]);
  bodies_[0] = bodies_[1] = pose;
  for (int round = 0; round < kRounds; ++round) {
    refine(kernels, points, evaluations);
    assign(cells);
  }
  double one = 0, two = 0;
  int explained[2] = {0, 0};
  for (size_t i = 0; i < apart_.size(); ++i) {
    const float e = residuals_[apart_[i]][i];
    one += static_cast<double>(std::min(residuals[i], 1.f));
    two += static_cast<double>(std::min(e, 1.f));
    explained[apart_[i]] += e < 1;
  }
  found_ = two < kMostCost * one;
  if (!found_) return;
  const int larger = explained[1] > explained[0];
  if (larger == 1) {
    for (uint8_t& apart : apart_) apart = 1 - apart;
  }
  pose = bodies_[larger];
  smaller_share_ = static_cast<double>(explained[1 - larger]) / std::max(1, explained[larger]);
}

void BodyParting::refine(const ResidualKernels& kernels, const PointColumnsView& points, int64_t& evaluations) {
  columns_.reserve(apart_.size());
  own_.resize(points.count);  // storage for all of them, so that how many there are allocates nothing
  for (int k = 0; k < 2; ++k) {
    columns_.clear();
    for (int i = 0; i < points.count; ++i) {
      if (apart_[static_cast<size_t>(i)] == k) columns_.push_back(i);
    }
    const auto count = static_cast<int>(columns_.size());
    own_.gather(points, columns_.data(), count);
    const int passes = PoseModel(kernels, own_.view()).refine(kRobustLoss, kIterations, bodies_[k], kEnough);
    residuals_[k].resize(static_cast<size_t>(points.size));
    PoseModel(kernels, points).residualsInFront(bodies_[k], residuals_[k].data());
    evaluations += static_cast<int64_t>(count) * passes + points.count;
  }
}

void BodyParting::assign(const std::vector<int32_t>& cells) {
  second_worse_.assign(static_cast<size_t>(kSpreadGridSide) * kSpreadGridSide, 0.f);
  for (size_t i = 0; i < apart_.size(); ++i) {
    second_worse_[static_cast<size_t>(cells[i])] += std::min(residuals_[1][i], 1.f) - std::min(residuals_[0][i], 1.f);
  }
  for (size_t i = 0; i < apart_.size(); ++i) apart_[i] = second_worse_[static_cast<size_t>(cells[i])] < 0;
}

}  // namespace gms_ransac
