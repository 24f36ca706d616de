// ~rolling_shutter_readout: any method, for a camera that reads its rows one after another while it turns. The points
// of both images are moved to where the camera would have seen them when it read its middle row, so that the pose is
// that between the times of the middle rows. Derived and measured in doc/uncertainty.md.
#pragma once

#include <memory>
#include <vector>

#include "gms_ransac/method.h"

namespace gms_ransac {

class RollingShutter : public Method {
 public:
  RollingShutter(std::unique_ptr<Method> method, const RobustOptions& options);

  bool wantsMutualMatches() const override { return method_->wantsMutualMatches(); }
  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override {
    return method_->filter(reference, current, matches);
  }
  /// The method's estimate as it is, then by the turn that it shows until that changes no more, then by what another
  /// sensor says; the one that the matches fit best.
  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override;
  void postFilter(const Features& reference, const Features& current, const std::vector<Match>& matches,
                  const std::vector<int>& survivors, RobustResult& result) override {
    method_->postFilter(reference, current, matches, survivors, result);
  }
  bool filterDecides() const override { return method_->filterDecides(); }
  void reset() override { method_->reset(); }
  void setSeed(uint64_t seed) override { method_->setSeed(seed); }
  void setTimeLimit(const TimeLimit* limit) override { method_->setTimeLimit(limit); }

 private:
  /// With the turn of the pair itself, taken for even.
  void followPair(const PointPairs& pairs, const Camera& camera, RobustResult& result);
  /// With the rates of another sensor, where its turn is that of the images.
  void followPrior(const PointPairs& pairs, const Camera& camera, RobustResult& result);
  /// Estimates with the points moved, into candidate_. Returns how far the matches fit that better than `result`, by
  /// Vuong's statistic; infinite where only one of the two has a pose.
  double tryMoved(const PointPairs& pairs, const Camera& camera, const TurnRates& rates, RobustResult& result);
  /// The candidate becomes the result.
  void take(RowCorrection correction, RobustResult& result);
  /// Truncated squared residuals of each match, in squared thresholds: under the model, and under the turn alone.
  struct Costs {
    std::vector<float> model, turn;
  };
  /// `rates`: what the points were moved by.
  void weigh(const PointPairs& pairs, const Camera& camera, const TurnRates& rates, const RobustResult& result,
             Costs& costs) const;
  /// How far such a turn moves a point of the first or last row, pixels.
  double moves(const Eigen::Vector3d& rate, const Camera& camera) const;

  std::unique_ptr<Method> method_;
  double readout_, threshold_px_;
  PointPairs moved_;
  RobustResult candidate_;
  Costs costs_, candidate_costs_;  ///< the former of the result; empty: not weighed yet
  std::vector<int32_t> cells_;     ///< of the matches
  std::vector<double> by_cell_;
};

/// Moves the points of both images to where the camera would have seen them when it read the middle row. `readout`:
/// seconds from the first row to the last. `moved` becomes the pairs, those points apart; it keeps its storage.
void moveToMiddleRow(const PointPairs& pairs, const Camera& camera, double readout, const TurnRates& rates,
                     PointPairs& moved);

}  // namespace gms_ransac
