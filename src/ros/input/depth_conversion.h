// Depth messages -> metres.
#pragma once

#include <string>

#include <sensor_msgs/Image.h>
#include <opencv2/core/mat.hpp>

namespace gms_ransac {

/// 32FC1 (metres) or 16UC1 / mono16 (millimetres; 0: unknown) as CV_32FC1 metres, not positive or not finite where
/// unknown. `depth` may share the message's memory. Returns an empty string or what is wrong; never throws.
std::string toDepth(const sensor_msgs::Image& image, cv::Size expected_size, cv::Mat& depth);

}  // namespace gms_ransac
