// A point of the left of two rectified images -> where the right one shows it, to a fraction of a pixel.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {

/// Compares the horizontal gradients of halved images, which a difference in brightness leaves alone, along the row;
/// then aligns the grey levels.
class RowSearch {
 public:
  explicit RowSearch(SimdLevel simd = detectSimdLevel()) : simd_(simd), kernels_(featureKernels(simd)) {}

  /// CV_8UC1, of one size; must outlive the search. `infinity`: disparity of what is infinitely far away, pixels.
  void setImages(const cv::Mat& left, const cv::Mat& right, double infinity);
  /// Pixels by which the right image shows a point farther to the left: at most a quarter of the width more than at
  /// infinity. None if the point is not found, or if another place on the row looks as much like it.
  /// `below`: pixels by which the right image shows the point lower.
  std::optional<double> disparity(const cv::Point2f& point, double below = 0);
  /// Searches in the left image for points of the right one: as if these images were exchanged.
  std::unique_ptr<RowSearch> exchanged() const;
  /// Rows by which the right image shows a point lower, to two pixels: at most `reach` up or down.
  std::optional<int> rowsBelow(const cv::Point2f& point, int reach);

 private:
  struct Place {
    int position = -1;  ///< the best; -1: none stands out
    int16_t difference = INT16_MAX;
  };
  void toGradients(const cv::Mat& image, Plane& gradients);
  /// Where on the row of the right halved image the window at (x, y) of the left one is.
  Place searchRow(int x, int y, int rows_below);
  static Place standsOut(const int16_t* differences, int count);
  std::optional<double> align(const cv::Point& point, const cv::Point& right_point, double below) const;

  const SimdLevel simd_;
  const FeatureKernels& kernels_;
  cv::Mat left_, right_;
  Plane half_, left_gradients_, right_gradients_;  ///< halved images
  double infinity_px_ = 0;
  int infinity_ = 0;  ///< pixels of the halved images
  std::vector<int16_t> differences_, of_rows_;
};

}  // namespace gms_ransac
