// Messages as a fuzzed input describes them: sound ones, and such as claim what is not so.
#pragma once

#include <array>
#include <string>

#include <ros/console.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <boost/make_shared.hpp>

#include "fuzz_input.h"

namespace gms_ransac {

/// Wall time, and no log, which would be most of the work.
inline void quietRos() {
  static const bool done = [] {
    ros::Time::init();
    ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Fatal);
    ros::console::notifyLoggerLevelsChanged();
    return true;
  }();
  static_cast<void>(done);
}

inline ros::Time fuzzedStamp(FuzzInput& input) {
  const int kind = input.between(0, 3);
  if (kind == 1) return ros::Time(0);
  if (kind > 1) return ros::Time(1000 + input.byte(), 1000000u * input.byte());
  return ros::Time(input.raw<uint32_t>(), input.raw<uint32_t>() % 1000000000u);
}

/// As many pixels as there should be, or not; noise, or flat squares that have corners.
inline void fillPixels(FuzzInput& input, sensor_msgs::Image& image, size_t bytes) {
  constexpr size_t kMostBytes = 1 << 20;
  image.data.resize(std::min(bytes, kMostBytes));
  Random random = input.random();
  const int square = input.between(0, 15);
  if (square == 0) {
    const std::string spelt_out = input.bytes(image.data.size());
    std::copy(spelt_out.begin(), spelt_out.end(), image.data.begin());
    return;
  }
  const size_t row = std::max<size_t>(image.step, 1);
  for (size_t i = 0; i < image.data.size(); ++i) {
    const uint64_t block = (i / row / static_cast<size_t>(square)) * 65537 + i % row / static_cast<size_t>(square);
    image.data[i] = square == 1 ? static_cast<uint8_t>(random.next()) : static_cast<uint8_t>(Random(block).next());
  }
}

/// `encodings`: to choose from, but for the odd text of the input's own.
template <typename Encodings>
sensor_msgs::ImagePtr fuzzedImage(FuzzInput& input, const Encodings& encodings, int most_side) {
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp = fuzzedStamp(input);
  image->encoding = encodings[0];
  const uint8_t kind = input.byte();
  image->encoding = kind < 240 ? std::string(input.oneOf(encodings)) : input.text(64);
  image->width = static_cast<uint32_t>(input.between(0, most_side));
  image->height = static_cast<uint32_t>(input.between(0, most_side));
  image->is_bigendian = input.byte() & 3;
  const uint8_t step = input.byte();
  static const std::array<uint32_t, 6> kPixelBytes = {1, 2, 3, 4, 6, 8};
  image->step = image->width * input.oneOf(kPixelBytes) + (step < 200 ? 0u : step - 200u);
  size_t bytes = size_t{image->step} * image->height;
  const int wrong = input.between(0, 15);
  if (wrong == 0) bytes = input.raw<uint16_t>();
  if (wrong == 1) bytes -= std::min<size_t>(bytes, input.byte());
  if (wrong == 2) image->width = input.raw<uint32_t>();
  if (wrong == 3) image->height = input.raw<uint32_t>();
  if (wrong == 4) image->step = input.raw<uint32_t>();
  fillPixels(input, *image, bytes);
  return image;
}

/// Around what `width` x `height` images have.
inline sensor_msgs::CameraInfoPtr fuzzedCameraInfo(FuzzInput& input, int width, int height) {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = static_cast<uint32_t>(width);
  info->height = static_cast<uint32_t>(height);
  static const std::array<const char*, 8> kModels = {
      "plumb_bob", "rational_polynomial", "equidistant", "fisheye", "radtan", "none", "", "thin prism"};
  info->distortion_model = input.oneOf(kModels);
  static const std::array<int, 8> kCounts = {0, 4, 5, 8, 12, 14, 3, 100};
  const int coefficients = input.oneOf(kCounts);
  const double size = std::pow(10.0, input.within(-3, 1));
  for (int i = 0; i < coefficients; ++i) info->D.push_back(input.number(-size, size));
  for (size_t i : {0u, 4u}) info->K[i] = input.number(0.3 * width, 2 * width);
  info->K[2] = input.number(0, width);
  info->K[5] = input.number(0, height);
  info->K[8] = 1;
  if (input.flag()) {
    for (size_t i : {0u, 5u}) info->P[i] = input.number(0.3 * width, 2 * width);
    info->P[2] = input.number(0, width);
    info->P[6] = input.number(0, height);
  }
  if (input.byte() > 224) {
    info->binning_x = input.raw<uint32_t>();
    info->binning_y = input.byte();
    info->roi.x_offset = input.raw<uint32_t>();
    info->roi.y_offset = input.byte();
    info->roi.width = input.raw<uint16_t>();
    info->roi.height = input.raw<uint32_t>();
    info->width = input.raw<uint32_t>();
  }
  return info;
}

}  // namespace gms_ransac
