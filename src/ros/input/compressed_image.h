// CompressedImage messages as images: the node reads them itself, since not every system has a transport that does.
#pragma once

#include <string>

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

namespace gms_ransac {

/// An image whose data are those of the message, decoded when they are used: images that are dropped cost nothing.
sensor_msgs::ImageConstPtr stillCompressed(const sensor_msgs::CompressedImage& message);

/// Replaces an image that is still compressed by its pixels: mono, bgr or Bayer, of 8 or 16 bits. Leaves others alone.
/// Returns an empty string, or what is wrong. Never throws.
std::string decompress(sensor_msgs::ImageConstPtr& image);

}  // namespace gms_ransac
