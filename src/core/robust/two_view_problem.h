// One pair's matches as the estimators see them: the three models behind one face of solve, count and check.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/camera.h"
#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

/// Where matches without places are put, working coordinates: far from every line and from where any motion takes them.
constexpr float kNowhere = 1e3f;

constexpr int kMaxSampleSize = 7;
constexpr int kMaxModels = 10;

/// Matches that a sampler has put in some order, as columns in the working coordinates of TwoViewProblem.
struct OrderedPoints {
  std::vector<float> x_reference, y_reference, x_current, y_current;

  int size() const { return static_cast<int>(x_reference.size()); }
  void resize(int n);
};

/// Works in normalised coordinates for the essential matrix. For the others each image is moved to its centre and
/// both are divided by one common scale: numbers near 1 for the solvers, and residuals that differ from pixels by that
/// scale alone.
class TwoViewProblem {
 public:
  /// `camera` may be uncalibrated unless `type` is essential. Keeps references to nothing; reuses its storage.
  void set(const PointPairs& pairs, const Camera& camera, ModelType type, double threshold_px);

  ModelType type() const { return type_; }
  int size() const { return all_.size(); }
  int sampleSize() const;
  double threshold() const { return threshold_; }  ///< in working coordinates
  /// Copies the matches in the order given.
  void arrange(const std::vector<int>& order, OrderedPoints& points) const;

  /// Models of a minimal sample; returns how many. Models that are not finite are left out.
  int solve(const OrderedPoints& points, const int* sample, Eigen::Matrix3d models[kMaxModels]) const;
  /// True when one match is within the threshold.
  bool fits(const Eigen::Matrix3d& model, const OrderedPoints& points, int i) const;
  /// The same of all points as a mask, in float; `inlier` has as many entries.
  void markInliers(const Eigen::Matrix3d& model, const OrderedPoints& points, std::vector<uint8_t>& inlier) const;

  /// The model in the units of RobustResult::model, of unit Frobenius norm.
  Eigen::Matrix3d inResultUnits(const Eigen::Matrix3d& model) const;

 private:
  ModelType type_ = ModelType::kEssential;
  OrderedPoints all_;
  Eigen::Matrix3d to_working_reference_, to_working_current_;  ///< pixels -> working coordinates
  double threshold_ = 0;                                       ///< in working coordinates
};

/// Fills result.inlier, inlier_count and rms_error_px with the verdict of result.model on the pairs, in double.
void markFinalInliers(const PointPairs& pairs, const Camera& camera, double threshold_px, RobustResult& result);

}  // namespace gms_ransac
