#include "input/compressed_image.h"

#include <cv_bridge/cv_bridge.h>
#include <boost/make_shared.hpp>

#include "features/encoded_image.h"
#include "guard.h"
#include "text.h"

namespace gms_ransac {

namespace {

// Stands in `encoding` before the format of the message; no encoding begins like this.
const std::string kStillCompressed = "compressed: ";

sensor_msgs::ImageConstPtr decoded(const sensor_msgs::Image& packed, const std::string& format) {
  const DecodedImage image = decodeImage(packed.data, format);
  if (image.pixels.empty()) return nullptr;
  return cv_bridge::CvImage(packed.header, image.encoding, image.pixels).toImageMsg();
}

}  // namespace

sensor_msgs::ImageConstPtr stillCompressed(const sensor_msgs::CompressedImage& message) {
  const auto image = boost::make_shared<sensor_msgs::Image>();
  image->header = message.header;
  image->encoding = kStillCompressed + message.format;
  image->data = message.data;
  return image;
}

std::string decompress(sensor_msgs::ImageConstPtr& image) {
  if (!image || image->encoding.rfind(kStillCompressed, 0) != 0) return std::string();
  const std::string format = image->encoding.substr(kStillCompressed.size());
  std::string problem = "OpenCV reads no JPEG, PNG or other picture in it";
  sensor_msgs::ImageConstPtr pixels;
  guarded([&] { pixels = decoded(*image, format); }, [&](const std::string& what) { problem = what; });
  if (!pixels) {
    return "it cannot be decoded (format '" + excerpt(format) + "', " + std::to_string(image->data.size()) +
           " bytes): " + problem;
  }
  image = pixels;
  return std::string();
}

}  // namespace gms_ransac
