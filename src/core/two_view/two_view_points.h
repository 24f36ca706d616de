// The matches of a pair as all that estimates sees them: aligned columns, built once from the survivors.
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
/// Every row of the pair has a slot of the columns. Slots are a pseudo-random order of the rows, so that the first of
/// them are a random part. Nobody outside of the estimator sees them: its results are in rows.
class TwoViewPoints {
 public:
  /// The noise of a keypoint, and the threshold with it, grows as scale_factor^(noise_exponent * octave). `camera` may
  /// be uncalibrated unless `type` is essential.
  void set(const PointPairs& pairs, const Camera& camera, ModelType type, double threshold_px, double noise_exponent);

  ModelType type() const { return type_; }
  void countInto(int64_t* evaluations) { columns_.countInto(evaluations); }
  int size() const { return columns_.count(); }
  PointColumnsView view() const { return columns_.view(); }
  const std::vector<int32_t>& cells() const { return cells_; }  ///< of each slot
  /// Replaces each row by its slot.
  void toSlots(std::vector<int>& rows) const;
  size_t rowOf(int slot) const { return static_cast<size_t>(row_of_[static_cast<size_t>(slot)]); }
  double noiseExponent() const { return noise_exponent_; }
  double pixelsPerUnit() const { return pixels_per_unit_; }
  /// The weight of a slot whose keypoints are both of the finest level.
  float finestWeight() const { return finest_weight_; }
  /// Weighs the aligned points by their own noise, from the squared residuals of a motion that most matches follow.
  void weighAligned(const std::vector<float>& squared_residuals);
  /// Standard deviation of aligned points, in those of keypoints of the finest level; 1 until they are weighed.
  double alignedSigma() const { return aligned_sigma_; }
  /// Sorts a value of each slot by rows.
  void toRows(const std::vector<float>& by_slot, std::vector<float>& by_row) const;

  Eigen::Matrix3d inResultUnits(const Eigen::Matrix3d& model) const;

 private:
  ModelType type_ = ModelType::kEssential;
  PointColumns columns_;
  std::vector<int32_t> cells_;
  std::vector<int> row_of_, slot_of_;
  std::vector<uint8_t> aligned_;                               ///< flags of the slots
  std::vector<float> of_keypoints_, of_aligned_;               ///< squared residuals
  Eigen::Matrix3d to_working_reference_, to_working_current_;  ///< pixels -> working coordinates
  double pixels_per_unit_ = 1, noise_exponent_ = 0, aligned_sigma_ = 1;
  float finest_weight_ = 1;
};

/// The residual of a model in the units of RobustResult::model, in double.
class FinalResidual {
 public:
  /// `stretch`: by which points and their noise were stretched along y; residuals are in pixels before it.
  FinalResidual(const Camera& camera, ModelType type, const Eigen::Matrix3d& model, double stretch_reference = 1,
                double stretch_current = 1);
  /// Calls visit(row, squared residual in pixels) for every row; of one without coordinates the residual is any.
  template <typename Visit>
  void forEach(const PointPairs& pairs, const Visit& visit) const {
    constexpr size_t kBlock = 64;
    double residuals[kBlock];
    const auto n = static_cast<size_t>(pairs.size());
    for (size_t first = 0; first < n; first += kBlock) {
      const size_t last = std::min(n, first + kBlock);
      squared(pairs, first, last, residuals);
      for (size_t row = first; row < last; ++row) visit(row, residuals[row - first]);
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
