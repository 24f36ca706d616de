// An image message becomes a grey image of its size, or is refused with a sentence; the message stays as it is. So does
// a compressed one, whole or damaged: what was encoded is decoded.
#include <opencv2/imgcodecs.hpp>

#include "exif.h"
#include "fuzz_messages.h"
#include "input/compressed_image.h"
#include "input/image_conversion.h"

namespace gms_ransac {
namespace {

const std::vector<std::string>& encodings() {
  static const std::vector<std::string> all = {"mono8",        "8UC1",         "bgr8",   "8UC3",         "rgb8",
                                               "bgra8",        "8UC4",         "rgba8",  "bayer_rggb8",  "bayer_bggr8",
                                               "bayer_gbrg8",  "bayer_grbg8",  "mono16", "16UC1",        "bgr16",
                                               "rgb16",        "bgra16",       "rgba16", "bayer_rggb16", "bayer_bggr16",
                                               "bayer_gbrg16", "bayer_grbg16", "yuv422", "yuv422_yuy2",  "nv12",
                                               "nv21",         "nv24",         "32FC1",  "jpeg"};
  return all;
}

void checkRaw(FuzzInput& input) {
  while (!input.empty()) {
    const sensor_msgs::ImagePtr image = fuzzedImage(input, encodings(), 200);
    const sensor_msgs::Image before = *image;
    cv::Mat grey;
    const std::string problem = toGrey(*image, grey);
    demand(image->data == before.data, "the message is only read");
    demand(problem.size() < 1000, "a refusal is short whatever the message says");
    demand(problem.empty() != grey.empty(), "an image or a sentence");
    if (!problem.empty()) continue;
    demand(grey.type() == CV_8UC1, "the image is grey");
    const bool has_colour_rows = image->encoding.rfind("nv", 0) == 0 && grey.rows < static_cast<int>(image->height);
    demand(grey.cols == static_cast<int>(image->width), "the image has the message's width");
    demand(has_colour_rows || grey.rows == static_cast<int>(image->height), "the image has the message's height");
    demand(cv::sum(grey)[0] >= 0, "every pixel can be read");
  }
}

/// Brighter to the right and further down, so that no rotation or reflection shows the same.
cv::Mat slope(FuzzInput& input) {
  static const std::vector<int> kTypes = {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3};
  const int width = input.between(1, 120), height = input.between(1, 120), type = input.oneOf(kTypes);
  const double step = (CV_MAT_DEPTH(type) == CV_8U ? 200.0 : 60000.0) / (width + 2 * height);
  cv::Mat pixels(height, width, type);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) pixels(cv::Rect(x, y, 1, 1)) = cv::Scalar::all(step * (x + 2 * y));
  }
  return pixels;
}

std::string encoded(FuzzInput& input, const cv::Mat& pixels, bool jpeg) {
  std::vector<uint8_t> bytes;
  cv::imencode(jpeg ? ".jpg" : ".png", pixels, bytes);
  std::string text(bytes.begin(), bytes.end());
  if (jpeg && input.flag()) setExifOrientation(input.between(1, 8), text);
  return text;
}

/// Returns true if anything was changed.
bool damage(FuzzInput& input, std::string& bytes) {
  const std::string whole = bytes;
  for (int n = input.between(0, 5) - 2; n > 0; --n) {
    const int at = input.between(0, static_cast<int>(bytes.size()) - 1), kind = input.between(0, 3);
    if (kind == 0) bytes.resize(static_cast<size_t>(at) + 1);
    if (kind == 1) bytes.insert(static_cast<size_t>(at), input.text(20));
    if (kind > 1) bytes[static_cast<size_t>(at)] = static_cast<char>(input.byte());
  }
  return bytes != whole;
}

void checkCompressed(FuzzInput& input) {
  const cv::Mat pixels = slope(input);
  const bool jpeg = pixels.depth() == CV_8U && input.flag();
  std::string bytes = encoded(input, pixels, jpeg);
  const bool damaged = damage(input, bytes);
  sensor_msgs::CompressedImage message;
  message.header.stamp = fuzzedStamp(input);
  message.format = input.flag() ? "bayer_rggb8; png compressed " : input.text(100);
  message.data.assign(bytes.begin(), bytes.end());
  const sensor_msgs::ImageConstPtr packed = stillCompressed(message);
  sensor_msgs::ImageConstPtr image = packed;
  const std::string problem = decompress(image);
  demand(problem.size() < 1000, "a refusal is short whatever the message says");
  demand(problem.empty() != (image == packed), "pixels or a sentence");
  demand(problem.empty() || damaged, "an undamaged picture is decoded: " + problem);
  demand(image->header.stamp == message.header.stamp, "the stamp is the message's");
  if (!problem.empty()) return;
  const std::string before = image->encoding;
  demand(decompress(image).empty() && image->encoding == before, "it is decoded once");
  cv::Mat grey;
  const std::string refusal = toGrey(*image, grey);
  demand(refusal.empty() || std::min(image->width, image->height) < 24 || damaged, "it is an image: " + refusal);
  if (damaged) return;
  const bool wide = pixels.depth() == CV_16U;
  const bool mosaic = pixels.channels() == 1 && before.rfind("bayer_", 0) == 0;
  const std::string colours = mosaic ? before.substr(0, 10) : pixels.channels() == 1 ? "mono" : "bgr";
  demand(before == colours + (wide ? "16" : "8"), "it is as encoded");
  demand(static_cast<int>(image->width) == pixels.cols && static_cast<int>(image->height) == pixels.rows,
         "it has the size that was encoded, however the camera was held");
  const double error = cv::norm(pixelsOf(*image, pixels.type()), pixels, cv::NORM_L1) /
                       static_cast<double>(pixels.total() * static_cast<size_t>(pixels.channels()));
  demand(error <= (jpeg ? 4 : 0), "every pixel is where it was: " + std::to_string(error));
}

}  // namespace

void check(FuzzInput input) {
  quietRos();
  if (input.flag()) return checkCompressed(input);
  checkRaw(input);
}

}  // namespace gms_ransac
