// Every encoding becomes the same grey picture; malformed messages are refused with a sentence.
#include "input/image_conversion.h"

#include <cv_bridge/cv_bridge.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

/// Smooth, coloured, and different along both axes.
cv::Mat colouredPicture() {
  cv::Mat picture(96, 128, CV_8UC3);
  for (int r = 0; r < picture.rows; ++r) {
    for (int c = 0; c < picture.cols; ++c) {
      picture.at<cv::Vec3b>(r, c) =
          cv::Vec3b(static_cast<uint8_t>(40 + c), static_cast<uint8_t>(2 * r), static_cast<uint8_t>(200 - c));
    }
  }
  return picture;
}

sensor_msgs::Image message(const cv::Mat& pixels, const std::string& encoding) {
  sensor_msgs::Image image;
  image.width = static_cast<uint32_t>(pixels.cols);
  image.height = static_cast<uint32_t>(pixels.rows);
  image.encoding = encoding;
  image.step = static_cast<uint32_t>(pixels.cols * pixels.elemSize());
  const cv::Mat whole = pixels.clone();
  image.data.assign(whole.data, whole.data + whole.total() * whole.elemSize());
  return image;
}

/// The pixels of a BGR picture in an encoding.
cv::Mat encode(const cv::Mat& bgr, const std::string& encoding) {
  cv::Mat pixels;
  if (encoding == "bgr8" || encoding == "8UC3") return bgr;
  if (encoding == "rgb8") cv::cvtColor(bgr, pixels, cv::COLOR_BGR2RGB);
  if (encoding == "bgra8" || encoding == "8UC4") cv::cvtColor(bgr, pixels, cv::COLOR_BGR2BGRA);
  if (encoding == "rgba8") cv::cvtColor(bgr, pixels, cv::COLOR_BGR2RGBA);
  if (encoding == "mono8" || encoding == "8UC1") cv::cvtColor(bgr, pixels, cv::COLOR_BGR2GRAY);
  if (encoding.compare(0, 6, "bayer_") == 0) {
    // The four letters name the colours of the first two rows of two pixels.
    pixels.create(bgr.size(), CV_8UC1);
    for (int r = 0; r < bgr.rows; ++r) {
      for (int c = 0; c < bgr.cols; ++c) {
        const char color = encoding[6 + 2 * (r % 2) + c % 2];
        pixels.at<uint8_t>(r, c) = bgr.at<cv::Vec3b>(r, c)[color == 'b' ? 0 : color == 'g' ? 1 : 2];
      }
    }
  }
  return pixels;
}

class Encodings : public testing::TestWithParam<const char*> {};

TEST_P(Encodings, BecomeTheSameGrey) {
  const cv::Mat bgr = colouredPicture();
  cv::Mat expected, grey;
  cv::cvtColor(bgr, expected, cv::COLOR_BGR2GRAY);
  const std::string encoding = GetParam();
  const sensor_msgs::Image image = message(encode(bgr, encoding), encoding);
  ASSERT_EQ(ImageConverter().toGrey(image, grey), "");
  ASSERT_EQ(grey.type(), CV_8UC1);
  // Interpolating a Bayer pattern blurs by a pixel; the picture changes by at most 3 grey levels over that distance.
  const bool bayer = encoding.compare(0, 6, "bayer_") == 0;
  const cv::Rect inside(2, 2, bgr.cols - 4, bgr.rows - 4);
  EXPECT_LE(cv::norm(grey(inside), expected(inside), cv::NORM_INF), bayer ? 3 : 1) << encoding;
}

INSTANTIATE_TEST_SUITE_P(ImageConversion, Encodings,
                         testing::Values("mono8", "8UC1", "bgr8", "8UC3", "rgb8", "bgra8", "8UC4", "rgba8",
                                         "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"));

TEST(ImageConversion, GreyImagesShareTheMessagesMemory) {
  const sensor_msgs::Image image = message(encode(colouredPicture(), "mono8"), "mono8");
  cv::Mat grey;
  ASSERT_EQ(ImageConverter().toGrey(image, grey), "");
  EXPECT_EQ(grey.data, image.data.data());
}

TEST(ImageConversion, TwelveBitsAreScaledNotCutOff) {
  cv::Mat wide(96, 128, CV_16UC1);
  for (int r = 0; r < wide.rows; ++r) {
    for (int c = 0; c < wide.cols; ++c) wide.at<uint16_t>(r, c) = static_cast<uint16_t>(4095 * c / (wide.cols - 1));
  }
  for (const char* encoding : {"mono16", "16UC1"}) {
    cv::Mat grey;
    ASSERT_EQ(ImageConverter().toGrey(message(wide, encoding), grey), "");
    EXPECT_EQ(grey.at<uint8_t>(5, 127), 255) << encoding;
    EXPECT_NEAR(grey.at<uint8_t>(5, 64), 255 * 64 / 127, 1) << encoding;
    EXPECT_EQ(grey.at<uint8_t>(5, 0), 0) << encoding;
  }
}

TEST(ImageConversion, BrightnessOfWideImagesDoesNotJump) {
  ImageConverter converter;
  cv::Mat grey;
  ASSERT_EQ(converter.toGrey(message(cv::Mat(96, 128, CV_16UC1, cv::Scalar(1000)), "mono16"), grey), "");
  const int before = grey.at<uint8_t>(0, 0);
  ASSERT_EQ(converter.toGrey(message(cv::Mat(96, 128, CV_16UC1, cv::Scalar(900)), "mono16"), grey), "");
  EXPECT_NEAR(grey.at<uint8_t>(0, 0), before * 0.9, 1);
}

/// Values as of a thermal camera: from `low` on, `width` of them from left to right.
cv::Mat ramp(int low, int width) {
  cv::Mat wide(96, 128, CV_16UC1);
  for (int c = 0; c < wide.cols; ++c) wide.col(c) = cv::Scalar(low + width * c / (wide.cols - 1));
  return wide;
}

TEST(ImageConversion, AFewValuesFarAboveZeroFillTheGreyLevels) {
  ImageConverter converter;
  const auto levels = [&converter](const cv::Mat& wide) {
    cv::Mat grey;
    EXPECT_EQ(converter.toGrey(message(wide, "mono16"), grey), "");
    return std::make_pair(static_cast<int>(grey.at<uint8_t>(0, 0)), static_cast<int>(grey.at<uint8_t>(0, 127)));
  };
  const auto first = levels(ramp(18450, 540));
  EXPECT_NEAR(first.second - first.first, 170, 2) << "two thirds of them";
  EXPECT_NEAR(levels(ramp(18500, 440)).first, first.first + 50 * 255 / 810, 1) << "the range serves the next image";
  const auto hot = levels(ramp(18450, 5000));
  EXPECT_NEAR(hot.second - hot.first, 170, 2) << "something hot comes into view";
  const auto after = levels(ramp(18450, 540));
  EXPECT_NEAR(after.second - after.first, 170, 2) << "and leaves it";
  EXPECT_LT(levels(ramp(18000, 20)).second, 100) << "noise stays small";
  EXPECT_NEAR(levels(ramp(0, 4095)).second, 255 * 4095 / 32767, 1) << "a scene that starts at 0 is scaled by the bits";
}

TEST(ImageConversion, BigEndianIsUnderstood) {
  const cv::Mat wide(96, 128, CV_16UC1, cv::Scalar(0x0102));
  sensor_msgs::Image little = message(wide, "mono16"), big = little;
  for (size_t i = 0; i < big.data.size(); i += 2) std::swap(big.data[i], big.data[i + 1]);
  big.is_bigendian = 1;
  cv::Mat a, b;
  ASSERT_EQ(ImageConverter().toGrey(little, a), "");
  ASSERT_EQ(ImageConverter().toGrey(big, b), "");
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
}

TEST(ImageConversion, SaysWhatIsWrong) {
  const sensor_msgs::Image good = message(encode(colouredPicture(), "mono8"), "mono8");
  cv::Mat grey;
  const auto problem = [&](auto change) {
    sensor_msgs::Image image = good;
    change(image);
    return ImageConverter().toGrey(image, grey);
  };
  EXPECT_NE(problem([](auto& i) { i.encoding = "sepia"; }).find("'sepia'"), std::string::npos);
  EXPECT_NE(problem([](auto& i) { i.data.clear(); }).find("empty"), std::string::npos);
  EXPECT_NE(problem([](auto& i) { i.step = 3; }).find("step is 3"), std::string::npos);
  EXPECT_NE(problem([](auto& i) { i.step += 1; }).find("step * height"), std::string::npos);
  EXPECT_NE(problem([](auto& i) {
              i.width = 10;
              i.height = 10;
              i.step = 10;
              i.data.resize(100);
            }).find("10x10"),
            std::string::npos);
  EXPECT_NE(problem([](auto& i) { i.width = 100000; }).find("too large"), std::string::npos);
  EXPECT_TRUE(grey.empty());
}

TEST(ImageConversion, QuotesAnEncodingInPart) {
  sensor_msgs::Image image = message(cv::Mat(96, 128, CV_8UC1, cv::Scalar(0)), "mono8");
  image.encoding = std::string(100000, 'x');
  cv::Mat converted;
  EXPECT_LT(ImageConverter().toGrey(image, converted).size(), 300U);
  EXPECT_LT(toDepth(image, {128, 96}, converted).size(), 300U);
  image.encoding = "\x1b[2Jmono\n";
  EXPECT_NE(ImageConverter().toGrey(image, converted).find("'?[2Jmono?'"), std::string::npos);
}

TEST(DepthConversion, MetresAndMillimetresAndWhatIsNeither) {
  const cv::Size size(128, 96);
  const sensor_msgs::Image metres = message(cv::Mat(size, CV_32FC1, cv::Scalar(2.5)), "32FC1");
  cv::Mat shared, depth;
  ASSERT_EQ(toDepth(metres, size, shared), "");
  EXPECT_EQ(shared.at<float>(7, 9), 2.5F);
  sensor_msgs::Image millimetres = message(cv::Mat(size, CV_16UC1, cv::Scalar(2500)), "16UC1");
  ASSERT_EQ(toDepth(millimetres, size, depth), "");
  EXPECT_EQ(depth.at<float>(7, 9), 2.5F);
  const auto expectRefused = [&](const sensor_msgs::Image& image, cv::Size expected, const char* words) {
    const std::string problem = toDepth(image, expected, depth);
    EXPECT_NE(problem.find(words), std::string::npos) << problem;
  };
  expectRefused(millimetres, {64, 96}, "the depth image is 128x96, but the image is 64x96");
  expectRefused(message(cv::Mat(size, CV_8UC1, cv::Scalar(7)), "mono8"), size, "'mono8'; it must be 32FC1");
  millimetres.is_bigendian = 1;
  expectRefused(millimetres, size, "big-endian");
  millimetres.data.clear();
  expectRefused(millimetres, size, "empty");
}

TEST(ImageConversion, AnOddStepOfWidePixelsIsNamed) {
  sensor_msgs::Image image = message(cv::Mat(96, 320, CV_16UC1, cv::Scalar(7)), "mono16");
  image.step = 641;
  image.data.resize(641 * 96);
  cv::Mat grey;
  EXPECT_NE(ImageConverter().toGrey(image, grey).find("step is 641 bytes, no multiple of the 2 bytes"),
            std::string::npos);
  image.encoding = "16UC1";
  EXPECT_NE(toDepth(image, {320, 96}, grey).find("step is 641 bytes, no multiple of the 2 bytes"), std::string::npos);
}

}  // namespace
}  // namespace gms_ransac
