// 16-bit images keep their contrast whatever else is in them: hot pixels, reflectors, telemetry, a sky far away in
// values.
#include "features/wide_image.h"

#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

const cv::Rect kUnspoiled(60, 60, 200, 100);  // of all the images below

/// Blurred noise in values from `low` on, about `width` of them.
cv::Mat texture(int low, int width) {
  cv::Mat noise(240, 320, CV_32FC1), wide;
  cv::theRNG().state = 3;
  cv::randu(noise, 0, 1);
  cv::GaussianBlur(noise, noise, {}, 2);
  cv::normalize(noise, noise, low, low + width, cv::NORM_MINMAX);
  noise.convertTo(wide, CV_16U);
  return wide;
}

double contrast(const cv::Mat& grey) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(grey(kUnspoiled), mean, deviation);
  return deviation[0];
}

cv::Mat telemetry(const cv::Size& size) {
  cv::Mat rows(size, CV_16UC1);
  cv::theRNG().state = 4;
  cv::randu(rows, 0, 65536);
  return rows;
}

TEST(WideImage, WhatFewPixelsShowTakesNoContrast) {
  const struct {
    std::string name;
    std::function<void(cv::Mat&)> spoil;
  } spoilers[] = {{"hot pixel", [](cv::Mat& wide) { wide.at<uint16_t>(200, 300) = 65535; }},
                  {"reflector",
                   [](cv::Mat& wide) {
                     wide({280, 200, 18, 9}) = 65535;
                   }},
                  {"large reflector",
                   [](cv::Mat& wide) {
                     wide({280, 180, 40, 39}) = 65535;
                   }},
                  {"two black rows", [](cv::Mat& wide) { wide.rowRange(238, 240) = 0; }},
                  {"telemetry", [](cv::Mat& wide) {
                     telemetry({320, 7}).copyTo(wide.rowRange(233, 240));
                   }}};
  for (const auto& [low, width] : {std::pair(0, 1000), std::pair(0, 4000), std::pair(18000, 400)}) {
    const cv::Mat clean = texture(low, width);
    const double before = contrast(wideToGrey(clean));
    EXPECT_GT(before, 30);
    for (const auto& spoiler : spoilers) {
      cv::Mat spoiled = clean.clone();
      spoiler.spoil(spoiled);
      EXPECT_GT(contrast(wideToGrey(spoiled)), 0.7 * before) << spoiler.name << " beside " << width << " from " << low;
    }
  }
}

TEST(WideImage, SkyAndGroundBothKeepTheirContrast) {
  cv::Mat wide = texture(18000, 400);
  wide.rowRange(160, 240) = 9000;
  EXPECT_GT(contrast(wideToGrey(wide)), 25) << "a sky that shows nothing";
  wide = texture(18000, 400);
  wide.colRange(160, 320) += 6000;
  const cv::Mat grey = wideToGrey(wide);
  for (const int left : {20, 200}) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(grey({left, 20, 100, 200}), mean, deviation);
    EXPECT_GT(deviation[0], 12) << "half of the view hot, from column " << left;
  }
}

/// Where values lie close together grey levels grow evenly with them.
TEST(WideImage, IsLinearWhereValuesLieTogether) {
  for (const auto& [low, width] :
       {std::pair(0, 4095), std::pair(0, 1023), std::pair(18450, 540), std::pair(0, 65535)}) {
    cv::Mat wide(96, 1024, CV_16UC1);
    for (int c = 0; c < wide.cols; ++c) wide.col(c) = cv::Scalar(low + width * c / (wide.cols - 1));
    ValueRange range;
    const cv::Mat grey = wideToGrey(wide, &range);
    for (int c = 0; c < wide.cols; ++c) EXPECT_NEAR(grey.at<uint8_t>(5, c), 255 * c / (wide.cols - 1), 8);
    EXPECT_NEAR(range.low, low + 0.025 * width, 0.02 * width + 16);
    EXPECT_NEAR(range.high, low + 0.975 * width, 0.02 * width + 16);
  }
}

TEST(WideImage, NoiseOfAPlainImageStaysSmall) {
  cv::Mat noise(240, 320, CV_16UC1);
  for (int start : {0, 500, 18000, 65500}) {
    cv::randn(noise, start + 20, 3);
    EXPECT_LT(contrast(wideToGrey(noise)), 12) << start;
  }
  for (int value : {0, 1000, 65535}) {
    const cv::Mat grey = wideToGrey(cv::Mat(96, 128, CV_16UC1, cv::Scalar(value)));
    EXPECT_NEAR(grey.at<uint8_t>(0, 0), 128, 16) << value;
    EXPECT_EQ(contrast(wideToGrey(cv::Mat(240, 320, CV_16UC1, cv::Scalar(value)))), 0);
  }
}

}  // namespace
}  // namespace gms_ransac
