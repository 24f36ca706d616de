#include "features/pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "gms_ransac/features.h"

namespace gms_ransac {

Pyramid::Pyramid(int levels, double scale_factor, int smallest, const FeatureKernels& kernels)
    : kernels_(kernels), smallest_(smallest), levels_(levels) {
  // Rounded to float as in cv::ORB: the sizes of the levels depend on it.
  for (int i = 0; i < levels; ++i) {
    levels_[i].nominal_scale = static_cast<float>(std::pow(static_cast<double>(static_cast<float>(scale_factor)), i));
  }
}

void Pyramid::layOut(cv::Size size) {
  size_ = size;
  used_ = 0;
  if (std::max(size.width, size.height) > Features::kLargestSide) return;
  for (Level& level : levels_) {
    const float inverse = 1.0f / static_cast<float>(level.nominal_scale);
    const int width = static_cast<int>(std::lrint(size.width * inverse));
    const int height = static_cast<int>(std::lrint(size.height * inverse));
    if (width < smallest_ || height < smallest_) break;
    level.plane.resize(width, height);
    level.scale = {static_cast<float>(size.width) / width, static_cast<float>(size.height) / height};
    if (used_ > 0) {
      const Plane& previous = levels_[used_ - 1].plane;
      level.columns.build(previous.width(), width);
      level.rows.build(previous.height(), height);
    }
    ++used_;
  }
  for (auto& buffer : row_buffer_) buffer.resize(size.width + 2 * ResizeTable::kPadding);
}

void Pyramid::build(const cv::Mat& image) {
  if (image.size() != size_) layOut(image.size());
  if (used_ == 0) return;
  Plane& base = levels_[0].plane;
  for (int y = 0; y < image.rows; ++y) std::memcpy(base.row(y), image.ptr(y), image.cols);
  for (int i = 1; i < used_; ++i) resizeFromPrevious(i);
}

void Pyramid::resizeFromPrevious(int i) {
  const Plane& source = levels_[i - 1].plane;
  Level& level = levels_[i];
  Plane& target = level.plane;
  uint16_t* upper = row_buffer_[0].data();
  uint16_t* lower = row_buffer_[1].data();
  int upper_row = -1, lower_row = -1;
  for (int y = 0; y < target.height(); ++y) {
    const int first = level.rows.offset[y];
    const int second = level.rows.weight[y] > 0 ? first + 1 : first;
    if (first == lower_row) {
      std::swap(upper, lower);
      std::swap(upper_row, lower_row);
    }
    if (first != upper_row) kernels_.resizeRow(source.row(first), level.columns, target.width(), upper);
    if (second != lower_row && second != first) {
      kernels_.resizeRow(source.row(second), level.columns, target.width(), lower);
      lower_row = second;
    }
    upper_row = first;
    kernels_.blendRows(upper, second == first ? upper : lower, level.rows.weight[y], target.width(), target.row(y));
  }
}

}  // namespace gms_ransac
