// Compressed messages become the pixels that were encoded.
#include "input/compressed_image.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "exif.h"

namespace gms_ransac {
namespace {

TEST(CompressedImage, IsNotTurnedByItsExifOrientation) {
  cv::Mat pixels(40, 64, CV_8UC1);
  for (int x = 0; x < pixels.cols; ++x) pixels.col(x) = 3 * x;
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", pixels, jpeg);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    std::string photograph(jpeg.begin(), jpeg.end());
    setExifOrientation(orientation, photograph);
    sensor_msgs::CompressedImage message;
    message.data.assign(photograph.begin(), photograph.end());
    sensor_msgs::ImageConstPtr image = stillCompressed(message);
    ASSERT_EQ(decompress(image), "");
    ASSERT_EQ(image->width, 64U) << orientation;
    EXPECT_LT(image->data.front(), image->data.back()) << orientation;
    EXPECT_LT(image->data.front(), image->data[63]) << orientation;
  }
}

}  // namespace
}  // namespace gms_ransac
