// Tells an image that repeats the one before it from one that was measured. No sensor measures the same twice, bit for
// bit: an equal image comes from a driver that sends it again, from frozen memory, or from a simulator without noise.
#pragma once

#include <string>

#include <gms_ransac/Keypoints.h>
#include <sensor_msgs/Image.h>

namespace gms_ransac {

/// Returns how much of `image` is that of `before`, as the end of a sentence; empty: not enough for a copy. A copy has
/// half of the rows of the image before it, not counting rows of one colour, which dark or overexposed images repeat.
/// Compressed images are copies if all data are equal.
std::string copiedPart(const sensor_msgs::Image& before, const sensor_msgs::Image& image);
/// The same of keypoints: all positions and descriptors are those of the message before.
std::string copiedPart(const Keypoints& before, const Keypoints& keypoints);

}  // namespace gms_ransac
