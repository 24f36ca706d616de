// A small image patch that is found again in later images to a fraction of a pixel, also rotated, sheared or brighter.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

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
  /// Takes the patch around a pixel of `image` (CV_8UC1); false if it leaves the image or shows too little.
  bool cut(const cv::Mat& image, const Eigen::Vector2f& centre);
  /// Finds the patch within `reach` pixels of `guess`; nothing if the result does not look like it.
  std::optional<PatchPlace> find(const cv::Mat& image, const PatchPlace& guess, float reach) const;
  /// The same from that of `guesses` where the image looks most like the patch.
  std::optional<PatchPlace> find(const cv::Mat& image, const std::vector<PatchPlace>& guesses, float reach) const;

 private:
  static constexpr int kRadius = 5;  ///< pixels
  static constexpr int kSide = 2 * kRadius + 1, kPixels = kSide * kSide;
  using Samples = std::array<float, kPixels>;
  using Matrix6f = Eigen::Matrix<float, 6, 6>;
  using Vector6f = Eigen::Matrix<float, 6, 1>;

  static bool sample(const cv::Mat& image, const PatchPlace& place, Samples& samples);
  /// To mean 0 and length 1; returns the length before, 0 where they are all alike.
  static float normalize(Samples& samples);
  void weighGradients();
  Vector6f project(const Samples& difference) const;

  Samples intensity_;                ///< normalized
  Samples gradient_x_, gradient_y_;  ///< of it, 1/pixel
  Eigen::Matrix2f inverse_shift_;    ///< of the normal equations of a shift alone,
  Matrix6f inverse_affine_;          ///< and with a change of shape
};

}  // namespace gms_ransac
