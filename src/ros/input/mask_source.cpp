#include "input/mask_source.h"

#include <cstdlib>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "features/encoded_image.h"
#include "guard.h"
#include "input/image_conversion.h"
#include "text.h"

namespace gms_ransac {

namespace {

cv::Mat readFile(const std::string& path) {
  if (path.empty()) return {};
  cv::Mat mask;
  guarded([&] { mask = readImageFile(path, cv::IMREAD_GRAYSCALE); }, [](const std::string&) {});
  if (mask.empty()) {
    throw std::invalid_argument("parameter ~mask_file is '" + path +
                                "'; it must be the path of an image, and none can "
                                "be read there");
  }
  return mask;
}

/// Brings `mask` to the size; returns what is wrong when it has another shape.
std::string scale(cv::Size size, cv::Mat& mask) {
  if (mask.size() == size) return std::string();
  // The same shape, up to one pixel of the smaller of the two.
  const int64_t across = int64_t{mask.cols} * size.height, down = int64_t{mask.rows} * size.width;
  if (std::abs(across - down) > std::max(size.width, size.height)) {
    return "the mask is " + sizeText(mask.size()) + " and the image " + sizeText(size) +
           "; it must have the image's size, or its shape in another size";
  }
  cv::Mat scaled;
  cv::resize(mask, scaled, size, 0, 0, cv::INTER_NEAREST);
  mask = scaled;
  return std::string();
}

/// The pixels of a message; returns what is wrong with it.
std::string pixels(const sensor_msgs::Image& message, cv::Mat& mask) {
  if (message.encoding != "mono8" && message.encoding != "8UC1") {
    return "the encoding of the mask is '" + excerpt(message.encoding) +
           "'; send mono8, zero where no keypoint is to be taken";
  }
  const std::string problem = layoutProblem(message, CV_8UC1);
  if (!problem.empty()) return "the mask cannot be used: " + problem;
  mask = pixelsOf(message, CV_8UC1);
  return std::string();
}

}  // namespace

MaskSource::MaskSource(const Parameters& parameters)
    : of_each_image_(parameters.mask_sync == MaskSync::kExact), file_(readFile(parameters.mask_file)), mask_(file_) {}

std::string MaskSource::get(const sensor_msgs::ImageConstPtr& message, cv::Size size, cv::Mat& mask) {
  if (message != message_ || size != size_) {
    message_ = message;
    size_ = size;
    mask_ = file_;
    problem_.clear();
    if (message) problem_ = pixels(*message, mask_);
    if (problem_.empty() && !mask_.empty()) problem_ = scale(size, mask_);
    if (!problem_.empty()) mask_.release();
  }
  mask = mask_;
  if (of_each_image_ && !message && file_.empty()) return "none of its stamp came on ~mask";
  return problem_;
}

}  // namespace gms_ransac
