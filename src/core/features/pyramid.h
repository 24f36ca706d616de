// The scale pyramid of ORB, each level resized from the one before, bit for bit as cv::ORB builds it.
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {

class Pyramid {
 public:
  /// At most `levels`; levels smaller than `smallest` pixels are left out.
  Pyramid(int levels, double scale_factor, int smallest, const FeatureKernels& kernels);

  void build(const cv::Mat& image);

  int levels() const { return static_cast<int>(used_); }
  const Plane& level(int i) const { return levels_[i].plane; }
  /// Pixels of the image for one pixel of level i along x and y.
  cv::Point2f scale(int i) const { return levels_[i].scale; }
  double nominalScale(int i) const { return levels_[i].nominal_scale; }

 private:
  struct Level {
    double nominal_scale;
    cv::Point2f scale;
    Plane plane;
    ResizeTable columns, rows;  ///< from the level before
  };

  void layOut(cv::Size size);
  void resizeFromPrevious(int i);

  const FeatureKernels& kernels_;
  int smallest_;
  cv::Size size_;
  int used_ = 0;
  std::vector<Level> levels_;
  std::vector<uint16_t> row_buffer_[2];
};

}  // namespace gms_ransac
