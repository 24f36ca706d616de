// An image message becomes a grey image of its size, or is refused with a sentence; the message stays as it is.
#include <opencv2/core.hpp>

#include "fuzz_messages.h"
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

}  // namespace

void check(FuzzInput input) {
  quietRos();
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

}  // namespace gms_ransac
