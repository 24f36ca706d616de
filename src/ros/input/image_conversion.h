// Image messages -> 8-bit grey images, depth messages -> metres; a malformed message is refused with a sentence.
#pragma once

#include <optional>
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

/// `grey` (CV_8UC1) shares the message's memory when the encoding is already grey and 8 bits wide, so the message must
/// outlive it. Colour and Bayer images are reduced to grey; 16-bit images share out the grey levels (see `wideToGrey`),
/// and `range` is theirs, none for the others. Returns an empty string, or what is wrong with the message; then `grey`
/// is untouched. Never throws.
std::string toGrey(const sensor_msgs::Image& image, cv::Mat& grey, std::optional<ValueRange>* range = nullptr);

/// 32FC1 (metres) or 16UC1 / mono16 (millimetres; 0: unknown) as CV_32FC1 metres of the image's size, not positive or
/// not finite where unknown. A depth image whose sides are the same whole fraction of the image's is enlarged. `depth`
/// may share the message's memory. Returns an empty string or what is wrong.
std::string toDepth(const sensor_msgs::Image& image, cv::Size image_size, cv::Mat& depth);

/// Returns why depth (CV_32FC1, as of toDepth) cannot be in metres, and what to do; empty: no reason.
std::string doubtOfUnit(const cv::Mat& depth);

}  // namespace gms_ransac
