// Image messages -> 8-bit grey images, depth messages -> metres; a malformed message is refused with a sentence.
#pragma once

#include <string>

#include <sensor_msgs/Image.h>
#include <opencv2/core/mat.hpp>

#include "features/wide_image.h"

namespace gms_ransac {

/// Empty when the message describes pixels of this OpenCV type that are really there, or what is wrong with its size,
/// step or data. Its encoding is not looked at.
std::string layoutProblem(const sensor_msgs::Image& image, int type);

/// The pixels of a message without a layout problem; shares its memory, which must only be read.
cv::Mat pixelsOf(const sensor_msgs::Image& image, int type);

class ImageConverter {
 public:
  /// `grey` (CV_8UC1) shares the message's memory when the encoding is already grey and 8 bits wide, so the message
  /// must outlive it. Colour and Bayer images are reduced to grey; 16-bit images are scaled (see `WideImage`).
  /// Returns an empty string, or what is wrong with the message; then `grey` is untouched. Never throws.
  std::string toGrey(const sensor_msgs::Image& image, cv::Mat& grey);

 private:
  cv::Mat convert(const sensor_msgs::Image& image, int type, int color_to_grey);

  WideImage wide_;
};

/// 32FC1 (metres) or 16UC1 / mono16 (millimetres; 0: unknown) as CV_32FC1 metres, not positive or not finite where
/// unknown. `depth` may share the message's memory. Returns an empty string or what is wrong.
std::string toDepth(const sensor_msgs::Image& image, cv::Size expected_size, cv::Mat& depth);

}  // namespace gms_ransac
