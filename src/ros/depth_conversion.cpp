#include "depth_conversion.h"

namespace gms_ransac {

namespace {

constexpr double kMetresPerUnit = 0.001;  // of 16-bit depth, REP 118

}  // namespace

std::string toDepth(const sensor_msgs::Image& image, cv::Size expected, cv::Mat& depth) {
  const bool metres = image.encoding == "32FC1", millimetres = image.encoding == "16UC1" || image.encoding == "mono16";
  if (!metres && !millimetres) {
    return "the depth image has the encoding '" + image.encoding +
           "'; it must be 32FC1 (metres) or 16UC1 (millimetres)";
  }
  if (static_cast<int>(image.width) != expected.width || static_cast<int>(image.height) != expected.height) {
    return "the depth image is " + std::to_string(image.width) + "x" + std::to_string(image.height) +
           ", but the image is " + std::to_string(expected.width) + "x" + std::to_string(expected.height) +
           "; depth must be registered to it";
  }
  const size_t pixel = metres ? sizeof(float) : sizeof(uint16_t);
  if (image.step < image.width * pixel || image.data.size() != static_cast<size_t>(image.step) * image.height) {
    return "step and data of the depth image do not fit its size";
  }
  if (image.is_bigendian) return "the depth image is big-endian, which is not supported";
  const cv::Mat received(expected, metres ? CV_32FC1 : CV_16UC1, const_cast<uint8_t*>(image.data.data()), image.step);
  if (metres) {
    depth = received;
  } else {
    received.convertTo(depth, CV_32F, kMetresPerUnit);
  }
  return std::string();
}

}  // namespace gms_ransac
