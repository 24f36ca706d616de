// A small image patch that is found again in later images to a fraction of a pixel, also rotated, sheared or brighter.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/simd.h"
#include "matching/patch_kernels.h"

namespace gms_ransac {

/// Where a patch is: an offset d from its centre there lies at `centre` + `shape` d here.
struct PatchPlace {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();  ///< pixels, pixel centres at whole numbers
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();
};

/// Inverse compositional Gauss-Newton alignment (Baker & Matthews 2004) with the patch as first taken, so that errors
/// do not add up.
class Patch {
 public:
  explicit Patch(SimdLevel simd = detectSimdLevel()) : kernels_(&patchKernels(simd)) {}

  /// Takes the patch around a pixel of `image` (CV_8UC1); false if it leaves the image or shows too little.
  bool cut(const cv::Mat& image, const Eigen::Vector2f& centre);
  /// Finds the patch within `reach` pixels of `guess`; nothing if the result does not look like it.
  std::optional<PatchPlace> find(const cv::Mat& image, const PatchPlace& guess, float reach) const;
  /// The same from that of `guesses` where the image looks most like the patch.
  std::optional<PatchPlace> find(const cv::Mat& image, const std::vector<PatchPlace>& guesses, float reach) const;

 private:
  using Matrix6f = Eigen::Matrix<float, 6, 6>;
  using Vector6f = Eigen::Matrix<float, 6, 1>;

  /// Normalized; false if the place leaves the image or shows too little.
  bool sample(const cv::Mat& image, const PatchPlace& place, PatchNumbers& levels) const;
  void weighGradients();
  /// Sums over the pixels of numbers times the derivatives by a shift and by the entries of a change of shape.
  Vector6f project(const PatchNumbers& numbers) const;

  const PatchKernels* kernels_;
  PatchNumbers intensity_;                ///< normalized
  PatchNumbers gradient_x_, gradient_y_;  ///< of it, 1/pixel
  Vector6f gain_;                         ///< `intensity_`, projected
  Eigen::LLT<Eigen::Matrix2f> shift_;     ///< normal equations of a shift alone,
  Eigen::LLT<Matrix6f> affine_;           ///< and with a change of shape
};

}  // namespace gms_ransac
