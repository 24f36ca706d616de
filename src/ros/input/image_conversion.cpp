#include "input/image_conversion.h"

#include <algorithm>
#include <array>

#include <opencv2/imgproc.hpp>

#include "gms_ransac/features.h"
#include "guard.h"
#include "text.h"

namespace gms_ransac {

namespace {

// A keypoint needs the 31-pixel patch of its descriptor; below twice that an image cannot hold a useful set.
constexpr uint32_t kMinimumSide = 64;

constexpr int kNoConversion = -1;

/// How an encoding of sensor_msgs/image_encodings.h becomes grey.
struct Encoding {
  const char* name;
  int type;           ///< OpenCV type of the received pixels
  int color_to_grey;  ///< cv::ColorConversionCodes, kNoConversion when it is grey already
};

// ROS names a Bayer pattern by its first row, OpenCV by the second and third pixel of the second: rggb is "BG".
constexpr std::array<Encoding, 24> kEncodings = {{
    {"mono8", CV_8UC1, kNoConversion},
    {"8UC1", CV_8UC1, kNoConversion},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
    {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY},
    {"mono16", CV_16UC1, kNoConversion},
    {"16UC1", CV_16UC1, kNoConversion},
    {"bgr16", CV_16UC3, cv::COLOR_BGR2GRAY},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2GRAY},
    {"bgra16", CV_16UC4, cv::COLOR_BGRA2GRAY},
    {"rgba16", CV_16UC4, cv::COLOR_RGBA2GRAY},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2GRAY},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2},
}};

std::string shapeText(const sensor_msgs::Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

cv::Mat swapBytes(const cv::Mat& wide) {
  cv::Mat swapped = wide.clone();
  for (int r = 0; r < swapped.rows; ++r) {
    auto* row = swapped.ptr<uint16_t>(r);
    for (int c = 0; c < swapped.cols * swapped.channels(); ++c)
      row[c] = static_cast<uint16_t>(row[c] << 8 | row[c] >> 8);
  }
  return swapped;
}

constexpr double kMetresPerUnit = 0.001;  // of 16-bit depth, REP 118

}  // namespace

std::string layoutProblem(const sensor_msgs::Image& image, int type) {
  if (image.width == 0 || image.height == 0 || image.data.empty()) return "it is empty (" + shapeText(image) + ")";
  if (std::max(image.width, image.height) > Features::kLargestSide) {
    return "it is " + shapeText(image) + ", too large: a side has at most " + std::to_string(Features::kLargestSide) +
           " pixels";
  }
  const size_t row = static_cast<size_t>(image.width) * CV_ELEM_SIZE(type), value = CV_ELEM_SIZE1(type);
  const auto step = [&image] { return "step is " + std::to_string(image.step) + " bytes, "; };
  if (image.step < row) {
    return step() + "but a row of " + std::to_string(image.width) + " " + image.encoding + " pixels takes " +
           std::to_string(row);
  }
  if (image.step % value != 0) {
    return step() + "no multiple of the " + std::to_string(value) + " bytes that a value of " + image.encoding +
           " takes; rows may be padded by whole values only";
  }
  const size_t expected = static_cast<size_t>(image.step) * image.height;
  if (image.data.size() != expected) {
    return "data holds " + std::to_string(image.data.size()) + " bytes, but step * height is " +
           std::to_string(expected);
  }
  return std::string();
}

cv::Mat pixelsOf(const sensor_msgs::Image& image, int type) {
  // cv::Mat has no view of constant memory.
  return {static_cast<int>(image.height), static_cast<int>(image.width), type, const_cast<uint8_t*>(image.data.data()),
          image.step};
}

std::string ImageConverter::toGrey(const sensor_msgs::Image& image, cv::Mat& grey) {
  const auto* encoding = std::find_if(kEncodings.begin(), kEncodings.end(),
                                      [&](const Encoding& each) { return image.encoding == each.name; });
  if (encoding == kEncodings.end()) {
    return "the encoding '" + excerpt(image.encoding) +
           "' is not supported; send mono8, mono16, bgr8, rgb8, bgra8, rgba8, yuv422 or a bayer_* one";
  }
  std::string problem = layoutProblem(image, encoding->type);
  if (!problem.empty()) return problem;
  if (image.width < kMinimumSide || image.height < kMinimumSide) {
    return "the image is " + shapeText(image) + "; both sides must be at least " + std::to_string(kMinimumSide) +
           " pixels";
  }
  guarded([&] { grey = convert(image, encoding->type, encoding->color_to_grey); },
          [&](const std::string& what) { problem = "converting " + image.encoding + " failed: " + what; });
  return problem;
}

cv::Mat ImageConverter::convert(const sensor_msgs::Image& image, int type, int color_to_grey) {
  cv::Mat received = pixelsOf(image, type);
  const bool wide = CV_MAT_DEPTH(type) == CV_16U;
  if (wide && (image.is_bigendian != 0) != (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)) received = swapBytes(received);
  cv::Mat one_channel = received;
  if (color_to_grey != kNoConversion) {
    one_channel = cv::Mat();  // never in place: the message is shared with other subscribers
    cv::cvtColor(received, one_channel, color_to_grey);
  }
  return wide ? wide_.toGrey(one_channel) : one_channel;
}

std::string toDepth(const sensor_msgs::Image& image, cv::Size expected, cv::Mat& depth) {
  const bool metres = image.encoding == "32FC1", millimetres = image.encoding == "16UC1" || image.encoding == "mono16";
  if (!metres && !millimetres) {
    return "the depth image has the encoding '" + excerpt(image.encoding) +
           "'; it must be 32FC1 (metres) or 16UC1 (millimetres)";
  }
  if (static_cast<int>(image.width) != expected.width || static_cast<int>(image.height) != expected.height) {
    return "the depth image is " + shapeText(image) + ", but the image is " + sizeText(expected) +
           "; depth must be registered to it";
  }
  const int type = metres ? CV_32FC1 : CV_16UC1;
  const std::string problem = layoutProblem(image, type);
  if (!problem.empty()) return "the depth image cannot be used: " + problem;
  if (image.is_bigendian) return "the depth image is big-endian, which is not supported";
  depth = pixelsOf(image, type);
  if (millimetres) cv::Mat(depth).convertTo(depth, CV_32F, kMetresPerUnit);
  return std::string();
}

}  // namespace gms_ransac
