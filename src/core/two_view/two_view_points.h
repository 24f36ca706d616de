// The matches of a pair as all that estimates sees them: one set of aligned columns, built once from the survivors.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/camera.h"
#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_options.h"
#include "two_view/kernels/point_columns.h"

namespace gms_ransac {

/// Normalised coordinates for the essential matrix; otherwise each image is centred and both are divided by one scale.
/// The columns stand in a pseudo-random order, so that the first of them are a random part. This order is
/// internal: a search counts columns, and its results are in the order of the matches.
class TwoViewPoints {
 public:
  /// The noise of a keypoint, and the threshold with it, grows as scale_factor^(noise_exponent * octave). `camera` may
  /// be uncalibrated unless `type` is essential.
  void set(const PointPairs& pairs, const Camera& camera, ModelType type, double threshold_px, double noise_exponent);

  ModelType type() const { return type_; }
  void countInto(int64_t* evaluations) { columns_.countInto(evaluations); }
  int size() const { return columns_.count(); }
  PointColumnsView view() const { return columns_.view(); }
  const std::vector<int32_t>& cells() const { return cells_; }
  /// Replaces each match by its column.
  void toColumns(std::vector<int>& matches) const;
  size_t matchOf(int column) const { return static_cast<size_t>(match_of_[static_cast<size_t>(column)]); }
  double noiseExponent() const { return noise_exponent_; }
  double pixelsPerUnit() const { return pixels_per_unit_; }
  /// The weight of a match whose keypoints are both of the finest level.
  float finestWeight() const { return finest_weight_; }
  /// A number of each column, as one of each match.
  void inOrderOfMatches(const std::vector<float>& of_columns, std::vector<float>& of_matches) const;

  Eigen::Matrix3d inResultUnits(const Eigen::Matrix3d& model) const;

 private:
  ModelType type_ = ModelType::kEssential;
  PointColumns columns_;
  std::vector<int32_t> cells_;
  std::vector<int> match_of_, column_of_;
  Eigen::Matrix3d to_working_reference_, to_working_current_;  ///< pixels -> working coordinates
  double pixels_per_unit_ = 1, noise_exponent_ = 0;
  float finest_weight_ = 1;
};

/// The residual of a model in the units of RobustResult::model, in double.
class FinalResidual {
 public:
  /// `stretch`: by which points and their noise were stretched along y; residuals are in pixels before it.
  FinalResidual(const Camera& camera, ModelType type, const Eigen::Matrix3d& model, double stretch_reference = 1,
                double stretch_current = 1);
  /// Calls visit(match, squared residual in pixels) for every match; of one without coordinates the residual is any.
  template <typename Visit>
  void forEach(const PointPairs& pairs, const Visit& visit) const {
    constexpr size_t kBlock = 64;
    double residuals[kBlock];
    const auto n = static_cast<size_t>(pairs.size());
    for (size_t first = 0; first < n; first += kBlock) {
      const size_t last = std::min(n, first + kBlock);
      squared(pairs, first, last, residuals);
      for (size_t i = first; i < last; ++i) visit(i, residuals[i - first]);
    }
  }

 private:
  void squared(const PointPairs& pairs, size_t first, size_t last, double* residuals) const;
  template <typename Distance>
  void fill(const PointPairs& pairs, size_t first, size_t last, double* residuals, const Distance& distance) const;

  ModelType type_;
  double unit_;                                                ///< pixels per unit of the residual
  Eigen::Matrix3d to_reference_, to_current_;                  ///< of pixels
  Eigen::Matrix3d model_, inverse_ = Eigen::Matrix3d::Zero();  ///< the latter of a homography alone
};

}  // namespace gms_ransac
