#include "gms_ransac/point_pairs.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

int spreadColumn(float position, int length) {
  const float column = position * static_cast<float>(kSpreadGridSide) / static_cast<float>(std::max(1, length));
  return static_cast<int>(std::min(std::max(0.f, column), static_cast<float>(kSpreadGridSide - 1)));
}

}  // namespace

int32_t spreadCell(const cv::Point2f& pixel, const cv::Size& image) {
  return spreadColumn(pixel.y, image.height) * kSpreadGridSide + spreadColumn(pixel.x, image.width);
}

void PointPairs::resize(int n) {
  const auto size = static_cast<size_t>(n);
  for (auto* column : {&x_reference, &y_reference, &x_current, &y_current, &relative_score}) column->resize(size);
  for (auto* column : {&octave_reference, &octave_current}) column->resize(size);
  score.resize(size);
  for (auto* column : {&distance, &second_distance}) column->resize(size);
}

bool PointPairs::hasCoordinates(size_t i) const {
  constexpr float kFarthest = 1e6f;  // a fisheye lens of 10000 px reaches as far, 0.6 degrees short of a right angle
  const auto isCoordinate = [](float value) { return std::abs(value) < kFarthest; };  // nor NaN
  return isCoordinate(x_reference[i]) && isCoordinate(y_reference[i]) && isCoordinate(x_current[i]) &&
         isCoordinate(y_current[i]);
}

}  // namespace gms_ransac
