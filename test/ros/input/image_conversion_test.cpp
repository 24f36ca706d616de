// Every encoding becomes the same grey picture; malformed messages are refused with a sentence.
#include "input/image_conversion.h"

#include <cmath>
#include <functional>
#include <optional>

#include <cv_bridge/cv_bridge.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "says.h"

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

/// Rows that end amid a value.
void oddStep(sensor_msgs::Image& image) {
  image = message(cv::Mat(96, 320, CV_16UC1, cv::Scalar(7)), "mono16");
  image.step = 641;
  image.data.resize(641 * 96);
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

TEST(ImageConversion, EveryEncodingBecomesTheSameGrey) {
  const cv::Mat bgr = colouredPicture();
  cv::Mat expected, grey;
  cv::cvtColor(bgr, expected, cv::COLOR_BGR2GRAY);
  for (const std::string encoding : {"mono8", "8UC1", "bgr8", "8UC3", "rgb8", "bgra8", "8UC4", "rgba8", "bayer_rggb8",
                                     "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"}) {
    const sensor_msgs::Image image = message(encode(bgr, encoding), encoding);
    ASSERT_EQ(toGrey(image, grey), "");
    ASSERT_EQ(grey.type(), CV_8UC1);
    // Interpolating a Bayer pattern blurs by a pixel; the picture changes by at most 3 grey levels over that distance.
    const bool bayer = encoding.compare(0, 6, "bayer_") == 0;
    const cv::Rect inside(2, 2, bgr.cols - 4, bgr.rows - 4);
    EXPECT_LE(cv::norm(grey(inside), expected(inside), cv::NORM_INF), bayer ? 3 : 1) << encoding;
  }
}

TEST(ImageConversion, GreyImagesShareTheMessagesMemory) {
  const sensor_msgs::Image image = message(encode(colouredPicture(), "mono8"), "mono8");
  cv::Mat grey;
  ASSERT_EQ(toGrey(image, grey), "");
  EXPECT_EQ(grey.data, image.data.data());
}

TEST(ImageConversion, RowsMayBePadded) {
  cv::Mat wide = colouredPicture(), grey, expected;
  sensor_msgs::Image image = message(wide, "bgr8");
  image.width -= 8;
  ASSERT_EQ(toGrey(image, grey), "");
  cv::cvtColor(wide.colRange(0, wide.cols - 8), expected, cv::COLOR_BGR2GRAY);
  EXPECT_EQ(cv::norm(grey, expected, cv::NORM_INF), 0);
}

TEST(ImageConversion, WideImagesTellTheirValues) {
  cv::Mat wide(96, 128, CV_16UC1), grey;
  for (int c = 0; c < wide.cols; ++c) wide.col(c) = cv::Scalar(18000 + 4 * c);
  wide.at<uint16_t>(40, 40) = 65535;
  std::optional<ValueRange> range;
  for (const char* encoding : {"mono16", "16UC1"}) {
    ASSERT_EQ(toGrey(message(wide, encoding), grey, &range), "");
    EXPECT_GT(grey.at<uint8_t>(0, 120) - grey.at<uint8_t>(0, 8), 200);
    ASSERT_TRUE(range);
    EXPECT_NEAR(range->low, 18000, 32);
    EXPECT_NEAR(range->high, 18508, 32);
  }
  ASSERT_EQ(toGrey(message(encode(colouredPicture(), "mono8"), "mono8"), grey, &range), "");
  EXPECT_FALSE(range);
}

/// Brightness first, then rows of colours, which drivers count in height or not.
TEST(ImageConversion, RowsOfColoursAreLeftAway) {
  const cv::Mat picture = encode(colouredPicture(), "mono8");
  const struct {
    const char* encoding;
    int rows;
  } kinds[] = {{"nv12", 48}, {"nv21", 48}, {"nv24", 192}};
  for (const auto& kind : kinds) {
    cv::Mat all = picture.clone(), grey;
    all.push_back(cv::Mat(kind.rows, picture.cols, CV_8UC1, cv::Scalar(128)));
    sensor_msgs::Image image = message(all, kind.encoding);
    for (const int height : {picture.rows, all.rows}) {
      image.height = static_cast<uint32_t>(height);
      ASSERT_EQ(toGrey(image, grey), "") << kind.encoding;
      ASSERT_EQ(grey.size(), picture.size()) << kind.encoding;
      EXPECT_EQ(cv::norm(grey, picture, cv::NORM_INF), 0) << kind.encoding;
    }
    image.height = static_cast<uint32_t>(picture.rows);
    image.data.pop_back();
    EXPECT_TRUE(says(toGrey(image, grey), {"step * height is 12288, with the colours"}));
  }
}

TEST(ImageConversion, BigEndianIsUnderstood) {
  const cv::Mat wide(96, 128, CV_16UC1, cv::Scalar(0x0102));
  sensor_msgs::Image little = message(wide, "mono16"), big = little;
  for (size_t i = 0; i < big.data.size(); i += 2) std::swap(big.data[i], big.data[i + 1]);
  big.is_bigendian = 1;
  cv::Mat a, b;
  ASSERT_EQ(toGrey(little, a), "");
  ASSERT_EQ(toGrey(big, b), "");
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
}

TEST(ImageConversion, SaysWhatIsWrong) {
  using Image = sensor_msgs::Image;
  const Image good = message(encode(colouredPicture(), "mono8"), "mono8");
  const struct {
    std::function<void(Image&)> spoil;
    const char* words;
  } rows[] = {{[](Image& i) { i.encoding = "sepia"; }, "'sepia'"},
              {[](Image& i) { i.encoding = "\x1b[2Jmono\n"; }, "'?[2Jmono?'"},
              {[](Image& i) { i.encoding.assign(100000, 'x'); }, "'xxxx"},
              {[](Image& i) { i.data.clear(); }, "empty"},
              {[](Image& i) { i.step = 3; }, "step is 3"},
              {[](Image& i) { i.step += 1; }, "step * height"},
              {[](Image& i) { i = message(cv::Mat::zeros(10, 10, CV_8UC1), "mono8"); }, "10x10"},
              {[](Image& i) { i.width = 100000; }, "too large"},
              {oddStep, "step is 641 bytes, no multiple of the 2 bytes"}};
  for (const auto& row : rows) {
    Image image = good;
    row.spoil(image);
    cv::Mat grey;
    const std::string problem = toGrey(image, grey);
    EXPECT_TRUE(says(problem, {row.words}));
    EXPECT_LT(problem.size(), 300U);
    EXPECT_TRUE(grey.empty());
  }
}

TEST(DepthConversion, MetresAndMillimetresAndWhatIsNeither) {
  const cv::Size size(128, 96);
  const sensor_msgs::Image metres = message(cv::Mat(size, CV_32FC1, cv::Scalar(2.5)), "32FC1");
  sensor_msgs::Image millimetres = message(cv::Mat(size, CV_16UC1, cv::Scalar(2500)), "16UC1");
  for (const sensor_msgs::Image& image : {metres, millimetres}) {
    cv::Mat depth;
    ASSERT_EQ(toDepth(image, size, depth), "");
    EXPECT_EQ(depth.at<float>(7, 9), 2.5F);
  }
  const auto problem = [](const sensor_msgs::Image& image, cv::Size expected) {
    cv::Mat depth;
    return toDepth(image, expected, depth);
  };
  for (const cv::Size image : {cv::Size(64, 96), cv::Size(256, 96), cv::Size(200, 150), cv::Size(256, 384)}) {
    EXPECT_TRUE(says(problem(millimetres, image), {"the depth image is 128x96, but the image is"}));
  }
  sensor_msgs::Image other = message(cv::Mat(size, CV_8UC1, cv::Scalar(7)), "mono8");
  EXPECT_TRUE(says(problem(other, size), {"'mono8'; it must be 32FC1"}));
  other.encoding.assign(100000, 'x');
  EXPECT_LT(problem(other, size).size(), 300U);
  oddStep(other);
  EXPECT_TRUE(says(problem(other, {320, 96}), {"step is 641 bytes, no multiple of the 2 bytes"}));
  millimetres.is_bigendian = 1;
  EXPECT_TRUE(says(problem(millimetres, size), {"big-endian"}));
  millimetres.data.clear();
  EXPECT_TRUE(says(problem(millimetres, size), {"empty"}));
}

TEST(DepthConversion, OfAWholeFractionOfTheImagesSizeIsEnlarged) {
  cv::Mat millimetres(48, 64, CV_16UC1), depth;
  for (int c = 0; c < millimetres.cols; ++c) millimetres.col(c) = cv::Scalar(1000 + 10 * c);
  for (const int times : {2, 3}) {
    const cv::Size image(times * 64, times * 48);
    ASSERT_EQ(toDepth(message(millimetres, "16UC1"), image, depth), "");
    ASSERT_EQ(depth.size(), image);
    for (int u = 0; u < image.width; ++u) {
      EXPECT_FLOAT_EQ(depth.at<float>(image.height - 1, u), 1 + 0.01F * static_cast<float>(u / times)) << u;
    }
  }
}

TEST(DepthConversion, DoubtsUnitsThatCannotBeMetres) {
  const auto scaled = [](double unit) {
    cv::Mat depth(96, 128, CV_32FC1);
    for (int c = 0; c < depth.cols; ++c) depth.col(c) = cv::Scalar(std::round(600 + 11.3 * c) * unit);
    depth.rowRange(0, 30) = 0;
    return depth;
  };
  EXPECT_EQ(doubtOfUnit(scaled(0.001)), "");
  EXPECT_EQ(doubtOfUnit(scaled(0.1234)), "") << "a hundred metres";
  EXPECT_TRUE(says(doubtOfUnit(scaled(1)), {"the median depth is", "in whole metres: depth must be in metres"}));
  EXPECT_TRUE(says(doubtOfUnit(scaled(1.01)), {"m: depth must be in metres"}));
  EXPECT_TRUE(says(doubtOfUnit(scaled(1e-6)), {"the median depth is 0.001"}));
  EXPECT_EQ(doubtOfUnit(cv::Mat()), "");
  EXPECT_EQ(doubtOfUnit(cv::Mat::zeros(96, 128, CV_32FC1)), "");
  EXPECT_TRUE(says(doubtOfUnit(cv::Mat(std::vector<float>{0, 1500.5, 2600.2, 3000.1})), {"2.6e+03"}));
}

}  // namespace
}  // namespace gms_ransac
