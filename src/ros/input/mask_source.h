// The mask that goes with an image: ~mask as it came, or ~mask_file, in the size of the image.
#pragma once

#include <string>

#include <sensor_msgs/Image.h>
#include <opencv2/core/mat.hpp>

#include "parameters.h"

namespace gms_ransac {

class MaskSource {
 public:
  /// Throws std::invalid_argument with a sentence when ~mask_file cannot be read.
  explicit MaskSource(const Parameters& parameters);

  /// Sets `mask` to CV_8UC1 of `size`, zero where no keypoint may be taken; empty: they may be anywhere. `message` is
  /// the newest ~mask or that of the image's stamp; null: none has come. `mask` may share its memory, so the message
  /// must outlive it. Returns an empty string, or why there is no mask although there should be one.
  std::string get(const sensor_msgs::ImageConstPtr& message, cv::Size size, cv::Mat& mask);

 private:
  const bool of_each_image_;
  cv::Mat file_;

  // of the last call: most masks stay the same
  sensor_msgs::ImageConstPtr message_;
  cv::Size size_;
  cv::Mat mask_;
  std::string problem_;
};

}  // namespace gms_ransac
