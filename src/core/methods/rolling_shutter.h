// Any method for a rolling shutter, whose readout is given (~rolling_shutter_readout) or learnt. The points of both
// images are moved to where the camera saw them when it read its middle row, whose times the pose belongs to
// (doc/inside/judgement.md).
#pragma once

#include <memory>
#include <vector>

#include "methods/method.h"

namespace gms_ransac {

class RollingShutter : public Method {
 public:
  RollingShutter(std::unique_ptr<Method> method, const RobustOptions& options);

  bool wantsMutualMatches() const override { return method_->wantsMutualMatches(); }
  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override {
    return method_->filter(reference, current, matches);
  }
  /// Estimates as is, then corrected by the rotation found until that converges, then by another sensor's rates; keeps
  /// the best fit.
  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override;
  void postFilter(const Features& reference, const Features& current, MatchResult& result) override {
    method_->postFilter(reference, current, result);
  }
  bool filterDecides() const override { return method_->filterDecides(); }
  void setSeed(uint64_t seed) override { method_->setSeed(seed); }
  void setTimeLimit(const TimeLimit* limit) override { method_->setTimeLimit(limit); }

 private:
  void correctByPair(const PointPairs& pairs, const Camera& camera, RobustResult& result);
  void correctByPrior(const PointPairs& pairs, const Camera& camera, RobustResult& result);
  /// Estimates into candidate_ with the points moved. Returns Vuong's statistic of its fit over `result`'s; infinite
  /// where only one has a pose.
  double tryMoved(const PointPairs& pairs, const Camera& camera, const RotationRates& rates, RobustResult& result);
  void accept(RowCorrection correction, RobustResult& result);
  /// Truncated squared residuals of each row, in squared thresholds, under the model and under the rotation alone.
  struct Costs {
    std::vector<float> model, rotation;
  };
  void weigh(const PointPairs& pairs, const Camera& camera, const RotationRates& rates, const RobustResult& result,
             Costs& costs) const;
  /// 0: not known.
  double readoutOf(const PointPairs& pairs, const Camera& camera) const;
  double moves(const Eigen::Vector3d& rate, const Camera& camera) const;

  std::unique_ptr<Method> method_;
  double given_, threshold_px_;
  double readout_ = 0;  ///< of this pair, seconds from the first row to the last; 0: not known
  PointPairs moved_;
  RobustResult candidate_;
  Costs costs_, candidate_costs_;  ///< the former of the result; empty: not weighed yet
  std::vector<int32_t> cells_;     ///< of each row
};

/// Moves the points of both images to where the camera saw them when it read the middle row. `readout`: seconds from
/// the first row to the last. `moved` keeps its storage.
void moveToMiddleRow(const PointPairs& pairs, const Camera& camera, double readout, const RotationRates& rates,
                     PointPairs& moved);

}  // namespace gms_ransac
