// JPEG, PNG and other encoded images, of files and of compressed messages -> their pixels. An EXIF orientation never
// rotates them, since the camera's calibration describes them as they are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>

namespace gms_ransac {

/// Flags of OpenCV for pixels as they were encoded: grey or colour (BGR), of 8 or 16 bits.
constexpr int kAsEncoded = cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH;

/// Reads an image file. `flags`: of cv::imread. Empty for anything else; reading a pipe or a device would never end.
/// Throws cv::Exception for an image that claims to be too large.
inline cv::Mat readImageFile(const std::string& path, int flags = kAsEncoded) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return {};
  return cv::imread(path, flags | cv::IMREAD_IGNORE_ORIENTATION);
}

struct DecodedImage {
  cv::Mat pixels;
  std::string encoding;  ///< of sensor_msgs/image_encodings.h
};

/// Decodes the data of a sensor_msgs/CompressedImage. Pixels are empty unless OpenCV reads an image of 8 or 16 bits in
/// them. Throws cv::Exception. `format`: of the message. compressed_image_transport encodes the mosaic of a Bayer
/// camera as a grey image and names its pattern there ("bayer_rggb8; png compressed "); that of ROS 2 may reduce it to
/// grey before ("bayer_rggb8; jpeg compressed mono8").
inline DecodedImage decodeImage(const std::vector<uint8_t>& data, const std::string& format) {
  cv::Mat pixels = cv::imdecode(data, kAsEncoded | cv::IMREAD_IGNORE_ORIENTATION);
  if (pixels.depth() != CV_8U && pixels.depth() != CV_16U) return {};
  std::string colours = pixels.channels() == 1 ? "mono" : "bgr";
  for (const char* pattern : {"bayer_rggb", "bayer_bggr", "bayer_gbrg", "bayer_grbg"}) {
    const bool named = format.rfind(pattern, 0) == 0 && format.find("mono8") == std::string::npos;
    if (named && pixels.channels() == 1) colours = pattern;
  }
  return {pixels, colours + (pixels.depth() == CV_16U ? "16" : "8")};
}

}  // namespace gms_ransac
