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

/// Where a patch is searched, and what is accepted.
struct PatchSearch {
  float reach;            ///< pixels from the guess
  float likeness = 0.8F;  ///< least correlation with what is found; 0.7 to 0.85 make next to no difference for tracks
  /// A shift alone is the answer unless a change of shape explains so many times what it would by chance (F statistic):
  /// it has four more unknowns, and costs precision. 0: the shape always changes.
  float shape_gain = 0;
};

/// Inverse compositional Gauss-Newton alignment (Baker & Matthews 2004) with the patch as first taken, so that errors
/// do not add up.
class Patch {
 public:
  explicit Patch(SimdLevel simd = detectSimdLevel()) : kernels_(&patchKernels(simd)) {}

  /// Takes the patch around a pixel of `image` (CV_8UC1); false if it leaves the image or shows too little.
  bool cut(const cv::Mat& image, const Eigen::Vector2f& centre);
  /// Finds the patch from `guess`; nothing if the result does not look like it.
  std::optional<PatchPlace> find(const cv::Mat& image, const PatchPlace& guess, const PatchSearch& search) const;
  /// The same from that of `guesses` where the image looks most like the patch.
  std::optional<PatchPlace> find(const cv::Mat& image, const std::vector<PatchPlace>& guesses,
                                 const PatchSearch& search) const;

 private:
  using Matrix6f = Eigen::Matrix<float, 6, 6>;
  using Vector6f = Eigen::Matrix<float, 6, 1>;
  /// Normal equations of a shift and a change of shape, which most patches never need.
  struct Affine {
    Eigen::LLT<Matrix6f> normal;
    Vector6f gain;  ///< `intensity_`, projected
  };

  /// Normalized; false if the place leaves the image or shows too little.
  bool sample(const cv::Mat& image, const PatchPlace& place, PatchNumbers& levels) const;
  Affine affine() const;
  /// How many times more than chance a change of shape explains of what a shift leaves of `seen`, which is `alike`.
  float shapeGain(const Affine& shape, const PatchNumbers& seen, float alike) const;
  /// Sums over the pixels of numbers times the derivatives by a shift, and by the entries of a change of shape.
  Eigen::Vector2f projectToShift(const PatchNumbers& numbers) const;
  Vector6f project(const PatchNumbers& numbers) const;

  const PatchKernels* kernels_;
  PatchNumbers intensity_;                ///< normalized
  PatchNumbers gradient_x_, gradient_y_;  ///< of it, 1/pixel
  Eigen::Vector2f gain_;                  ///< `intensity_`, projected to a shift
  Eigen::LLT<Eigen::Matrix2f> shift_;     ///< normal equations of a shift alone
};

}  // namespace gms_ransac
