// Keypoints messages of ~input keypoints -> the core's features; a malformed message is refused with a sentence.
#pragma once

#include <string>
#include <vector>

#include <gms_ransac/Keypoints.h>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/features.h"

namespace gms_ransac {

/// Returns an empty string, or what is wrong with the message; then `features` are none of an image without size. Never
/// throws.
std::string toFeatures(const Keypoints& message, Features& features);

/// Metres, 0 where the message does not know them; empty: it has no depth.
std::vector<float> depthOf(const Keypoints& message);

/// Drops the keypoints where `mask` (CV_8UC1, of the image's size, or empty) is zero, with their entries of `depth`.
void dropMasked(const cv::Mat& mask, Features& features, std::vector<float>& depth);

}  // namespace gms_ransac
