#include "input/depth_conversion.h"

#include "excerpt.h"
#include "guard.h"
#include "input/image_conversion.h"

namespace gms_ransac {

namespace {

constexpr double kMetresPerUnit = 0.001;  // of 16-bit depth, REP 118

}  // namespace

std::string toDepth(const sensor_msgs::Image& image, cv::Size expected, cv::Mat& depth) {
  const bool metres = image.encoding == "32FC1", millimetres = image.encoding == "16UC1" || image.encoding == "mono16";
  if (!metres && !millimetres) {
    return "the depth image has the encoding '" + excerpt(image.encoding) +
           "'; it must be 32FC1 (metres) or 16UC1 (millimetres)";
  }
  if (static_cast<int>(image.width) != expected.width || static_cast<int>(image.height) != expected.height) {
    return "the depth image is " + std::to_string(image.width) + "x" + std::to_string(image.height) +
           ", but the image is " + std::to_string(expected.width) + "x" + std::to_string(expected.height) +
           "; depth must be registered to it";
  }
  const int type = metres ? CV_32FC1 : CV_16UC1;
  std::string problem = layoutProblem(image, type);
  if (!problem.empty()) return "the depth image cannot be used: " + problem;
  if (image.is_bigendian) return "the depth image is big-endian, which is not supported";
  guarded(
      [&] {
        const cv::Mat received = pixelsOf(image, type);
        if (metres) {
          depth = received;
        } else {
          received.convertTo(depth, CV_32F, kMetresPerUnit);
        }
      },
      [&](const std::string& what) { problem = "converting the depth image failed: " + what; });
  return problem;
}

}  // namespace gms_ransac
