#include "input/compressed_image.h"

#include <cv_bridge/cv_bridge.h>
#include <boost/make_shared.hpp>
#include <opencv2/imgcodecs.hpp>

#include "guard.h"
#include "text.h"

namespace gms_ransac {

namespace {

// Stands in `encoding` before the format of the message; no encoding begins like this.
const std::string kStillCompressed = "compressed: ";

/// The pixels, as they were encoded: grey or colour in OpenCV's order, of 8 or 16 bits. An EXIF orientation does not
/// rotate them, since camera_info describes them as they are.
sensor_msgs::ImageConstPtr decoded(const sensor_msgs::Image& packed) {
  constexpr int kAsEncoded = cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION;
  const cv::Mat pixels = cv::imdecode(packed.data, kAsEncoded);
  if (pixels.empty() || (pixels.depth() != CV_8U && pixels.depth() != CV_16U)) return nullptr;
  const std::string encoding = pixels.channels() == 1 ? "mono" : "bgr";
  return cv_bridge::CvImage(packed.header, encoding + (pixels.depth() == CV_16U ? "16" : "8"), pixels).toImageMsg();
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
  std::string problem = "OpenCV reads no JPEG, PNG or other picture in it";
  sensor_msgs::ImageConstPtr pixels;
  guarded([&] { pixels = decoded(*image); }, [&](const std::string& what) { problem = what; });
  if (!pixels) {
    return "it cannot be decoded (format '" + excerpt(image->encoding.substr(kStillCompressed.size())) + "', " +
           std::to_string(image->data.size()) + " bytes): " + problem;
  }
  image = pixels;
  return std::string();
}

}  // namespace gms_ransac
