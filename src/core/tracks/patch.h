// A small patch of an image that is found again in later images to a fraction of a pixel, wherever it turned, leaned or
// brightened meanwhile.
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace gms_ransac {

/// Where a patch is: an offset d from its centre there lies at `centre` + `shape` d here.
struct PatchPlace {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();  ///< pixels, pixel centres at whole numbers
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();
};

/// Alignment by Gauss-Newton on the difference of intensities, the steps composed inversely (Baker & Matthews 2004):
/// the patch is always compared with what it was when it was taken, so that errors do not add up from image to image.
class Patch {
 public:
  /// Takes the patch around a pixel of `image` (CV_8UC1). False, and of no use, where it would reach beyond the image
  /// or shows too little to be found again.
  bool take(const cv::Mat& image, const Eigen::Vector2f& centre);
  /// Where the patch is in `image`, searched from `guess` and no farther than `reach` pixels from there; nothing where
  /// what is found does not look like it.
  std::optional<PatchPlace> find(const cv::Mat& image, const PatchPlace& guess, float reach) const;

 private:
  static constexpr int kRadius = 5;  ///< pixels
  static constexpr int kSide = 2 * kRadius + 1, kPixels = kSide * kSide;
  using Samples = std::array<float, kPixels>;
  using Matrix6f = Eigen::Matrix<float, 6, 6>;
  using Vector6f = Eigen::Matrix<float, 6, 1>;

  static bool sample(const cv::Mat& image, const PatchPlace& place, Samples& samples);
  /// To mean 0 and length 1; returns the length before, 0 where they are all alike.
  static float normalize(Samples& samples);
  /// The normal equations, from the gradients.
  void weighGradients();
  /// Right side of the normal equations.
  Vector6f project(const Samples& difference) const;

  Samples intensity_;                ///< normalized
  Samples gradient_x_, gradient_y_;  ///< of it, 1/pixel
  Eigen::Matrix2f inverse_shift_;    ///< of the normal equations of a shift alone,
  Matrix6f inverse_affine_;          ///< and with a change of shape
};

}  // namespace gms_ransac
