// Compressed messages become the pixels that were encoded.
#include "input/compressed_image.h"

#include <string>
#include <tuple>
#include <vector>

#include <cv_bridge/cv_bridge.h>
#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>
#include <opencv2/imgcodecs.hpp>

#include "exif.h"
#include "input/image_conversion.h"

namespace gms_ransac {
namespace {

namespace encodings = sensor_msgs::image_encodings;

/// The message that the publisher of compressed_image_transport 1.14 makes of an image. `codec`: jpeg or png.
sensor_msgs::CompressedImage publishedAs(const std::string& codec, const sensor_msgs::Image& image) {
  std::string target;
  if (encodings::isColor(image.encoding)) {
    target = codec == "png" && encodings::bitDepth(image.encoding) == 16 ? "bgr16" : "bgr8";
  }
  sensor_msgs::CompressedImage message;
  message.format = image.encoding + "; " + codec + " compressed " + target;
  const cv_bridge::CvImageConstPtr pixels = cv_bridge::toCvCopy(image, target);
  cv::imencode(codec == "png" ? ".png" : ".jpg", pixels->image, message.data);
  return message;
}

/// Red on the left, green on the right.
sensor_msgs::Image redAndGreen(const std::string& encoding) {
  cv_bridge::CvImage colours({}, "bgr8", cv::Mat(64, 64, CV_8UC3, cv::Scalar(20, 30, 200)));
  colours.image.colRange(32, 64) = cv::Scalar(20, 200, 30);
  if (!encodings::isBayer(encoding)) return *cv_bridge::toCvCopy(*colours.toImageMsg(), encoding)->toImageMsg();
  cv::Mat mosaic(colours.image.size(), CV_8UC1);
  for (int y = 0; y < mosaic.rows; ++y) {
    for (int x = 0; x < mosaic.cols; ++x) {
      const char letter = encoding[std::string("bayer_").size() + static_cast<size_t>(2 * (y % 2) + x % 2)];
      mosaic.at<uint8_t>(y, x) = colours.image.at<cv::Vec3b>(y, x)[static_cast<int>(std::string("bgr").find(letter))];
    }
  }
  if (encodings::bitDepth(encoding) == 16) mosaic.convertTo(mosaic, CV_16U, 257);
  return *cv_bridge::CvImage({}, encoding, mosaic).toImageMsg();
}

cv::Mat greyOf(const sensor_msgs::CompressedImage& message) {
  sensor_msgs::ImageConstPtr image = stillCompressed(message);
  cv::Mat grey;
  EXPECT_EQ(decompress(image), "") << message.format;
  EXPECT_EQ(toGrey(*image, grey), "") << message.format;
  return grey.clone();
}

TEST(CompressedImage, IsTheImageThatWasPublished) {
  for (const std::string encoding :
       {"mono8", "mono16", "bgr8", "rgb8", "bgra8", "rgba8", "bgr16", "rgb16", "bgra16", "rgba16", "bayer_rggb8",
        "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8", "bayer_rggb16", "bayer_bggr16", "bayer_gbrg16", "bayer_grbg16"}) {
    const sensor_msgs::Image raw = redAndGreen(encoding);
    cv::Mat sent;
    ASSERT_EQ(toGrey(raw, sent), "");
    EXPECT_EQ(cv::norm(greyOf(publishedAs("png", raw)), sent, cv::NORM_INF), 0) << encoding;
    if (encodings::bitDepth(encoding) == 16) continue;  // a JPEG has 8
    const double error = cv::norm(greyOf(publishedAs("jpeg", raw)), sent, cv::NORM_L1);
    EXPECT_LT(error / static_cast<double>(sent.total()), 4) << encoding;
  }
}

TEST(CompressedImage, OfABayerCameraMayBeGreyOrColourAlready) {
  const cv::Mat grey(40, 64, CV_8UC1, cv::Scalar(90)), colour(40, 64, CV_8UC3, cv::Scalar::all(90));
  for (const auto& [format, pixels, encoding] :
       {std::make_tuple("bayer_rggb8; jpeg compressed mono8", grey, "mono8"),
        std::make_tuple("bayer_rggb8; jpeg compressed bgr8", colour, "bgr8"),
        std::make_tuple("bayer_rggb8; jpeg compressed bayer_rggb8", grey, "bayer_rggb8"),
        std::make_tuple("bayer_unknown8; jpeg compressed ", grey, "mono8"),
        std::make_tuple("bayer_rggb16; jpeg compressed ", grey, "bayer_rggb8")}) {
    sensor_msgs::CompressedImage message;
    message.format = format;
    cv::imencode(".jpg", pixels, message.data);
    sensor_msgs::ImageConstPtr image = stillCompressed(message);
    ASSERT_EQ(decompress(image), "");
    EXPECT_EQ(image->encoding, encoding) << format;
  }
}

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
