// Points found on their rows: to a fraction of a pixel, not where the row repeats itself, and not elsewhere.
#include "matching/row_search.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

constexpr double kDisparity = 23.3;

/// Blurred noise.
cv::Mat texture() {
  cv::Mat image(120, 400, CV_8UC1);
  cv::theRNG().state = 1;
  cv::randu(image, 0, 256);
  cv::GaussianBlur(image, image, {}, 1.5);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

cv::Mat moved(const cv::Mat& image, double x, double y) {
  cv::Mat result;
  const cv::Mat_<double> motion = (cv::Mat_<double>(2, 3) << 1, 0, x, 0, 1, y);
  cv::warpAffine(image, result, motion, image.size(), cv::INTER_CUBIC);
  return result;
}

/// Mean of the disparities that are found of points in the middle, and how many are found, of 100.
struct Found {
  double mean = 0, largest_error = 0;
  int count = 0;

  Found(const cv::Mat& left, const cv::Mat& right, double infinity = 0) {
    RowSearch search;
    search.setImages(left, right, infinity);
    for (int i = 0; i < 100; ++i) {
      const cv::Point2f point(200.F + 1.6F * static_cast<float>(i % 50), 20.F + 0.8F * static_cast<float>(i));
      const std::optional<double> disparity = search.disparity(point);
      if (!disparity) continue;
      mean += *disparity;
      largest_error = std::max(largest_error, std::abs(*disparity - kDisparity));
      ++count;
    }
    if (count > 0) mean /= count;
  }
};

TEST(RowSearch, FindsAFractionOfAPixel) {
  const cv::Mat left = texture(), right = 0.8 * moved(left, -kDisparity, 0) + 30;
  const Found found(left, right);
  EXPECT_GT(found.count, 80);
  EXPECT_NEAR(found.mean, kDisparity, 0.1);
  EXPECT_LT(found.largest_error, 0.3);
}

TEST(RowSearch, LooksFromInfinityToAQuarterOfTheWidth) {
  const cv::Mat left = texture(), right = moved(left, -kDisparity, 0);
  EXPECT_GT(Found(left, right, kDisparity - 90).count, 80);
  EXPECT_GT(Found(left, right, kDisparity - 5).count, 80);
  EXPECT_EQ(Found(left, right, kDisparity - 130).count, 0);
  EXPECT_EQ(Found(left, right, kDisparity + 20).count, 0);
}

TEST(RowSearch, FindsNothingWhereTheRowRepeatsItself) {
  const cv::Mat tile = texture().colRange(0, 20);
  cv::Mat left;
  cv::repeat(tile, 1, 20, left);
  EXPECT_EQ(Found(left, moved(left, -kDisparity, 0)).count, 0);
}

TEST(RowSearch, TellsHowFarRowsAreOff) {
  const cv::Mat left = texture(), right = moved(left, -kDisparity, 12);
  EXPECT_LT(Found(left, right).count, 10);
  RowSearch search;
  search.setImages(left, right, 0);
  EXPECT_NEAR(search.rowsBelow({200, 60}, 40).value_or(0), 12, 2);
}

TEST(RowSearch, StaysWithinTheImage) {
  const cv::Mat image = texture();
  RowSearch search;
  search.setImages(image, image, 0);
  for (int x = -5; x < image.cols + 5; ++x) {
    for (const float y : {-3.F, 0.F, 4.F, 115.F, 119.F, 130.F}) {
      for (const double below : {0., -2.4, 3.7}) search.disparity({static_cast<float>(x), y}, below);
      search.rowsBelow({static_cast<float>(x), y}, 40);
    }
  }
}

}  // namespace
}  // namespace gms_ransac
