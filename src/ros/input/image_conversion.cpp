#include "input/image_conversion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "gms_ransac/features.h"
#include "guard.h"
#include "quantiles.h"
#include "text.h"

namespace gms_ransac {

namespace {

// Thermal arrays have 32x24 pixels; the extractor enlarges images of so few.
constexpr uint32_t kMinimumSide = 24;

constexpr int kNoConversion = -1;

/// How an encoding of sensor_msgs/image_encodings.h becomes grey.
struct Encoding {
  const char* name;
  int type;           ///< OpenCV type of the received pixels
  int color_to_grey;  ///< cv::ColorConversionCodes, kNoConversion when it is grey already
};

// ROS names a Bayer pattern by its first row, OpenCV by the second and third pixel of the second: rggb is "BG".
constexpr std::array<Encoding, 27> kEncodings = {{
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
    // Brightness first, then the colours in rows of their own.
    {"nv12", CV_8UC1, kNoConversion},
    {"nv21", CV_8UC1, kNoConversion},
    {"nv24", CV_8UC1, kNoConversion},
}};

/// Rows of colours that follow two rows of the picture.
uint32_t colourRows(const std::string& encoding) {
  if (encoding == "nv12" || encoding == "nv21") return 1;
  return encoding == "nv24" ? 4 : 0;
}

/// Height of the picture; some drivers count the rows of colours as well.
uint32_t pictureHeight(const sensor_msgs::Image& image) {
  const bool counts_all = image.data.size() == static_cast<size_t>(image.step) * image.height;
  return counts_all ? image.height * 2 / (2 + colourRows(image.encoding)) : image.height;
}

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

/// Brightness in as many bits as were sent; shares the message's memory where nothing is to be done.
cv::Mat oneChannel(const sensor_msgs::Image& image, const Encoding& encoding) {
  cv::Mat received = pixelsOf(image, encoding.type);
  const bool wide = CV_MAT_DEPTH(encoding.type) == CV_16U;
  if (wide && (image.is_bigendian != 0) != (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)) received = swapBytes(received);
  if (encoding.color_to_grey == kNoConversion) return received;
  cv::Mat one_channel;  // never in place: the message is shared with other subscribers
  cv::cvtColor(received, one_channel, encoding.color_to_grey);
  return one_channel;
}

constexpr double kMetresPerUnit = 0.001;  // of 16-bit depth, REP 118
// Median depth that a camera may measure, metres; the second farthest where all depths are whole numbers, as
// millimetres are.
constexpr float kNearest = 0.01F, kFarthest = 1000, kFarthestWhole = 50;
constexpr double kLookedAt = 1000;  ///< pixels of the depth image

/// True if an image is so many times as wide and as high as the depth.
bool isWholeFraction(cv::Size depth, cv::Size image) {
  return depth.width > 0 && depth.height > 0 && image.width % depth.width == 0 && image.height % depth.height == 0 &&
         image.width / depth.width == image.height / depth.height;
}

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
  const uint32_t colours = colourRows(image.encoding);
  const size_t expected = static_cast<size_t>(image.step) * image.height, all = expected + expected * colours / 2;
  if (image.data.size() != expected && image.data.size() != all) {
    return "data holds " + std::to_string(image.data.size()) + " bytes, but step * height is " +
           std::to_string(expected) + (colours > 0 ? ", with the colours " + std::to_string(all) : "");
  }
  return std::string();
}

cv::Mat pixelsOf(const sensor_msgs::Image& image, int type) {
  // cv::Mat has no view of constant memory.
  return {static_cast<int>(pictureHeight(image)), static_cast<int>(image.width), type,
          const_cast<uint8_t*>(image.data.data()), image.step};
}

std::string toGrey(const sensor_msgs::Image& image, cv::Mat& grey, std::optional<ValueRange>* range) {
  const auto* encoding = std::find_if(kEncodings.begin(), kEncodings.end(),
                                      [&](const Encoding& each) { return image.encoding == each.name; });
  if (encoding == kEncodings.end()) {
    return "the encoding '" + excerpt(image.encoding) +
           "' is not supported; send mono8, mono16, bgr8, rgb8, bgra8, rgba8, yuv422, nv12, nv21 or a bayer_* one";
  }
  std::string problem = layoutProblem(image, encoding->type);
  if (!problem.empty()) return problem;
  if (image.width < kMinimumSide || pictureHeight(image) < kMinimumSide) {
    return "the image is " + shapeText(image) + "; both sides must be at least " + std::to_string(kMinimumSide) +
           " pixels";
  }
  const auto convert = [&] {
    const cv::Mat values = oneChannel(image, *encoding);
    std::optional<ValueRange> used;
    if (values.depth() == CV_16U) used.emplace();
    grey = used ? wideToGrey(values, &*used) : values;
    if (range != nullptr) *range = used;
  };
  guarded(convert, [&](const std::string& what) { problem = "converting " + image.encoding + " failed: " + what; });
  return problem;
}

std::string toDepth(const sensor_msgs::Image& image, cv::Size image_size, cv::Mat& depth) {
  const bool metres = image.encoding == "32FC1", millimetres = image.encoding == "16UC1" || image.encoding == "mono16";
  if (!metres && !millimetres) {
    return "the depth image has the encoding '" + excerpt(image.encoding) +
           "'; it must be 32FC1 (metres) or 16UC1 (millimetres)";
  }
  const int type = metres ? CV_32FC1 : CV_16UC1;
  const std::string problem = layoutProblem(image, type);
  if (!problem.empty()) return "the depth image cannot be used: " + problem;
  if (image.is_bigendian) return "the depth image is big-endian, which is not supported";
  const cv::Mat received = pixelsOf(image, type);
  if (!isWholeFraction(received.size(), image_size)) {
    return "the depth image is " + shapeText(image) + ", but the image is " + sizeText(image_size) +
           "; depth must be registered to it, in its size or a whole fraction of it";
  }
  depth = received;
  if (millimetres) received.convertTo(depth, CV_32F, kMetresPerUnit);
  // Depth of the nearest pixel: a mean over the edge of a thing is the depth of nothing.
  if (depth.size() != image_size) cv::resize(cv::Mat(depth), depth, image_size, 0, 0, cv::INTER_NEAREST);
  return std::string();
}

std::string doubtOfUnit(const cv::Mat& depth) {
  const int step = 1 + static_cast<int>(std::sqrt(static_cast<double>(depth.total()) / kLookedAt));
  std::vector<float> known;
  for (int y = step / 2; y < depth.rows; y += step) {
    for (int x = depth.cols > 1 ? step / 2 : 0; x < depth.cols; x += step) {
      const float metres = depth.at<float>(y, x);
      if (metres > 0 && std::isfinite(metres)) known.push_back(metres);
    }
  }
  const float median = quantilesOf(known).median;
  const bool whole = std::all_of(known.begin(), known.end(), [](float metres) { return metres == std::floor(metres); });
  if (median == 0 || (median >= kNearest && median <= (whole ? kFarthestWhole : kFarthest))) return std::string();
  std::ostringstream text;
  text.precision(3);
  text << "the median depth is " << median << " m" << (whole ? ", all of it in whole metres" : "")
       << ": depth must be in metres, in 16-bit images in millimetres";
  return text.str();
}

}  // namespace gms_ransac
