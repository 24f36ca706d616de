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

void BodyParting::part(const JudgedPose& judged, int64_t& evaluations) {
  const std::vector<int32_t>& cells = judged.points.cells();
  apart_.resize(static_cast<size_t>(judged.points.size()));
  for (size_t i = 0; i < apart_.size(); ++i) apart_[i] = judged.spread.pose_break.holds(cells[i]);
  bodies_[0] = bodies_[1] = judged.pose;
  for (int round = 0; round < kRounds; ++round) {
    refine(judged.points.view(), evaluations);
    assign(cells);
  }
  double one = 0, two = 0;
  int explained[2] = {0, 0};
  for (size_t i = 0; i < apart_.size(); ++i) {
    const float e = residuals_[apart_[i]][i];
    one += static_cast<double>(std::min(judged.noise.residuals()[i], 1.f));
    two += static_cast<double>(std::min(e, 1.f));
    explained[apart_[i]] += e < 1;
  }
  found_ = two < kMostCost * one;
  if (!found_) return;
  if (explained[1] > explained[0]) {
    for (uint8_t& apart : apart_) apart = 1 - apart;
    std::swap(bodies_[0], bodies_[1]);
    std::swap(explained[0], explained[1]);
  }
  smaller_share_ = static_cast<double>(explained[1]) / std::max(1, explained[0]);
}

void BodyParting::refine(const PointColumnsView& points, int64_t& evaluations) {
  columns_.reserve(apart_.size());
  own_.resize(points.count);  // storage for all of them, so that how many there are allocates nothing
  for (int k = 0; k < 2; ++k) {
    columns_.clear();
    for (int i = 0; i < points.count; ++i) {
      if (apart_[static_cast<size_t>(i)] == k) columns_.push_back(i);
    }
    const auto count = static_cast<int>(columns_.size());
    own_.gather(points, columns_.data(), count);
    const int passes = PoseModel(kernels_, own_.view()).refine(kRobustLoss, kIterations, bodies_[k], kEnough);
    residuals_[k].resize(static_cast<size_t>(points.size));
    PoseModel(kernels_, points).residualsInFront(bodies_[k], residuals_[k].data());
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
