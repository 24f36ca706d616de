#include "two_view/two_view_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "support/order_statistics.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

namespace {

constexpr int kHighestOctave = 31;  ///< beyond it the noise is the same

/// Aligned points, and keypoints, from which on their noise is measured.
constexpr size_t kLeastOfClass = 20;
constexpr double kLeastAlignedSigma = 0.1;  ///< of keypoints' sigma: what is finer is an error of the camera model's

// Working coordinates of matches without: far from every line.
constexpr float kInvalidCoordinate = 1e3f;
constexpr float kTiny = 1e-12f;

using Column = std::vector<float> PointPairs::*;

/// Moves the centre of the points that have coordinates to the origin and divides by `scale`.
Eigen::Matrix3d centring(const PointPairs& pairs, Column x, Column y, double scale) {
  double sum_x = 0, sum_y = 0, n = 0;
  for (size_t row = 0; row < pairs.x_reference.size(); ++row) {
    if (!pairs.hasCoordinates(row)) continue;
    sum_x += (pairs.*x)[row];
    sum_y += (pairs.*y)[row];
    ++n;
  }
  n = std::max(1.0, n);
  Eigen::Matrix3d transform;
  transform << 1 / scale, 0, -sum_x / n / scale, 0, 1 / scale, -sum_y / n / scale, 0, 0, 1;
  return transform;
}

float transformed(const Eigen::Matrix3d& affine, int axis, float x, float y) {
  return static_cast<float>(affine(axis, 0) * x + affine(axis, 1) * y + affine(axis, 2));
}

/// Half the largest extent of the four columns, at least one pixel; of matches that have coordinates.
double halfExtent(const PointPairs& pairs) {
  double extent = 2;
  for (const Column column :
       {&PointPairs::x_reference, &PointPairs::y_reference, &PointPairs::x_current, &PointPairs::y_current}) {
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (size_t row = 0; row < pairs.x_reference.size(); ++row) {
      if (!pairs.hasCoordinates(row)) continue;
      low = std::min<double>(low, (pairs.*column)[row]);
      high = std::max<double>(high, (pairs.*column)[row]);
    }
    extent = std::max(extent, high - low);
  }
  return 0.5 * extent;
}

}  // namespace

void TwoViewPoints::set(const PointPairs& pairs, const Camera& camera, ModelType type, double threshold_px,
                        double noise_exponent) {
  type_ = type;
  noise_exponent_ = noise_exponent;
  if (type == ModelType::kEssential) {
    to_working_reference_ = to_working_current_ = camera.K().inverse();
    pixels_per_unit_ = camera.meanFocalLength();
  } else {
    pixels_per_unit_ = halfExtent(pairs);
    to_working_reference_ = centring(pairs, &PointPairs::x_reference, &PointPairs::y_reference, pixels_per_unit_);
    to_working_current_ = centring(pairs, &PointPairs::x_current, &PointPairs::y_current, pixels_per_unit_);
  }
  const double threshold = threshold_px / pixels_per_unit_;
  finest_weight_ = static_cast<float>(1 / (threshold * threshold));
  std::array<double, 256> variance;  // by octave, in squared thresholds
  for (size_t octave = 0; octave <= kHighestOctave; ++octave) {
    variance[octave] =
        std::pow(static_cast<double>(pairs.scale_factor), 2 * noise_exponent * static_cast<double>(octave));
  }
  std::fill(variance.begin() + kHighestOctave + 1, variance.end(), variance[kHighestOctave]);

  strideOver(pairs.size(), row_of_);
  columns_.resize(pairs.size());
  slot_of_.resize(row_of_.size());
  cells_.resize(row_of_.size());
  aligned_.resize(row_of_.size());
  aligned_sigma_ = 1;
  float *x1 = columns_.x1(), *y1 = columns_.y1(), *x2 = columns_.x2(), *y2 = columns_.y2();
  float* weight = columns_.weight();
  for (size_t slot = 0; slot < row_of_.size(); ++slot) {
    const auto row = static_cast<size_t>(row_of_[slot]);
    slot_of_[row] = static_cast<int>(slot);
    const float xr = pairs.x_reference[row], yr = pairs.y_reference[row];
    const float xc = pairs.x_current[row], yc = pairs.y_current[row];
    // Finite in any case, since sums over all matches follow that zero weights do not save from NaN.
    const bool valid = pairs.hasCoordinates(row);
    x1[slot] = valid ? transformed(to_working_reference_, 0, xr, yr) : 0;
    y1[slot] = valid ? transformed(to_working_reference_, 1, xr, yr) : 0;
    x2[slot] = valid ? transformed(to_working_current_, 0, xc, yc) : kInvalidCoordinate;
    y2[slot] = valid ? transformed(to_working_current_, 1, xc, yc) : -kInvalidCoordinate;
    aligned_[slot] = pairs.isAligned(row);
    // An aligned point has no level. Until weighAligned() it counts as a keypoint of the finest one.
    const double scale =
        aligned_[slot] ? 1 : 0.5 * (variance[pairs.octave_reference[row]] + variance[pairs.octave_current[row]]);
    weight[slot] = static_cast<float>(1 / (threshold * threshold * scale));
    cells_[slot] = spreadCell({xr, yr}, pairs.image_reference);
  }
}

void TwoViewPoints::weighAligned(const std::vector<float>& squared_residuals) {
  of_keypoints_.clear();
  of_aligned_.clear();
  for (size_t slot = 0; slot < aligned_.size(); ++slot) {
    const float residual = squared_residuals[slot];
    if (residual < 1) (aligned_[slot] ? of_aligned_ : of_keypoints_).push_back(residual);
  }
  if (std::min(of_keypoints_.size(), of_aligned_.size()) < kLeastOfClass) return;
  const auto median = [](std::vector<float>& values) { return nthSmallest(values, values.size() / 2); };
  const double ratio = std::sqrt(median(of_aligned_) / std::max(median(of_keypoints_), kTiny));
  aligned_sigma_ = std::clamp(aligned_sigma_ * ratio, kLeastAlignedSigma, 1.);
  const auto aligned_weight = static_cast<float>(finest_weight_ / (aligned_sigma_ * aligned_sigma_));
  for (size_t slot = 0; slot < aligned_.size(); ++slot) {
    if (aligned_[slot]) columns_.weight()[slot] = aligned_weight;
  }
}

void TwoViewPoints::toSlots(std::vector<int>& rows) const {
  for (int& entry : rows) entry = slot_of_[static_cast<size_t>(entry)];
}

void TwoViewPoints::toRows(const std::vector<float>& by_slot, std::vector<float>& by_row) const {
  by_row.resize(row_of_.size());
  for (size_t slot = 0; slot < row_of_.size(); ++slot) by_row[static_cast<size_t>(row_of_[slot])] = by_slot[slot];
}

Eigen::Matrix3d TwoViewPoints::inResultUnits(const Eigen::Matrix3d& model) const {
  Eigen::Matrix3d result = model;
  if (type_ == ModelType::kFundamental) {
    result = to_working_current_.transpose() * model * to_working_reference_;
  } else if (type_ == ModelType::kHomography) {
    result = to_working_current_.inverse() * model * to_working_reference_;
  }
  return result / result.norm();
}

FinalResidual::FinalResidual(const Camera& camera, ModelType type, const Eigen::Matrix3d& model,
                             double stretch_reference, double stretch_current)
    : type_(type), model_(model) {
  const bool essential = type == ModelType::kEssential;
  unit_ = essential ? camera.meanFocalLength() : 1;
  to_reference_ = to_current_ = essential ? Eigen::Matrix3d(camera.K().inverse()) : Eigen::Matrix3d::Identity();
  if (stretch_reference != 1 || stretch_current != 1) {
    const Eigen::Vector3d reference(1, stretch_reference, 1), current(1, stretch_current, 1);
    to_reference_ = reference.cwiseInverse().asDiagonal() * to_reference_;
    to_current_ = current.cwiseInverse().asDiagonal() * to_current_;
    model_ = model_ * reference.asDiagonal();
    const bool homography = type == ModelType::kHomography;
    model_ = (homography ? current.cwiseInverse().eval() : current).asDiagonal() * model_;
  }
  if (type == ModelType::kHomography) inverse_ = model_.inverse();
}

void FinalResidual::squared(const PointPairs& pairs, size_t first, size_t last, double* residuals) const {
  if (type_ == ModelType::kHomography) {
    fill(pairs, first, last, residuals, [H = model_, G = inverse_](double xr, double yr, double xc, double yc) {
      return transferSquared(H, G, xr, yr, xc, yc);
    });
  } else {
    fill(pairs, first, last, residuals,
         [M = model_](double xr, double yr, double xc, double yc) { return sampsonSquared(M, xr, yr, xc, yc); });
  }
}

template <typename Distance>
void FinalResidual::fill(const PointPairs& pairs, size_t first, size_t last, double* residuals,
                         const Distance& distance) const {
  // Copies, which stores to `residuals` cannot change: so the compiler takes several matches at a time.
  const Eigen::Matrix3d to_reference = to_reference_, to_current = to_current_;
  const double squared_unit = unit_ * unit_;
  const float *xr = pairs.x_reference.data(), *yr = pairs.y_reference.data();
  const float *xc = pairs.x_current.data(), *yc = pairs.y_current.data();
  for (size_t row = first; row < last; ++row) {
    const Eigen::Vector3d r = to_reference * Eigen::Vector3d(xr[row], yr[row], 1);
    const Eigen::Vector3d c = to_current * Eigen::Vector3d(xc[row], yc[row], 1);
    residuals[row - first] = squared_unit * distance(r.x(), r.y(), c.x(), c.y());
  }
}

}  // namespace gms_ransac
