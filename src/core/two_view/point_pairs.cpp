#include "gms_ransac/point_pairs.h"

#include <algorithm>

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

void PointPairs::gather(const PointPairs& all, const std::vector<int>& rows) {
  const auto copy = [&](auto column) {
    const auto& from = all.*column;
    auto& to = this->*column;
    to.clear();
    if (from.empty()) return;
    for (const int row : rows) to.push_back(from[static_cast<size_t>(row)]);
  };
  for (const auto column :
       {&PointPairs::x_reference, &PointPairs::y_reference, &PointPairs::x_current, &PointPairs::y_current,
        &PointPairs::relative_score, &PointPairs::row_reference, &PointPairs::row_current}) {
    copy(column);
  }
  for (const auto column : {&PointPairs::octave_reference, &PointPairs::octave_current, &PointPairs::aligned})
    copy(column);
  copy(&PointPairs::score);
  for (const auto column : {&PointPairs::distance, &PointPairs::second_distance}) copy(column);
  image_reference = all.image_reference;
  image_current = all.image_current;
  scale_factor = all.scale_factor;
  rotation_prior = all.rotation_prior;
  previous_motion = all.previous_motion;
  shutter = all.shutter;
  velocity_before = all.velocity_before;
  seconds = all.seconds;
}

}  // namespace gms_ransac
