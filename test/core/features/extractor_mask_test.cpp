// Keypoints under a mask: none where the mask is zero, the full number elsewhere, from either extractor.
#include "gms_ransac/feature_extractor.h"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

/// Corners of every size everywhere, twice as many as are asked for in each half.
cv::Mat texturedImage() {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(90));
  cv::RNG random(5);
  for (int i = 0; i < 3000; ++i) {
    const cv::Point corner(random.uniform(0, 640), random.uniform(0, 480));
    const cv::Size size(random.uniform(4, 30), random.uniform(4, 30));
    cv::rectangle(image, cv::Rect(corner, size), cv::Scalar(random.uniform(0, 255)), cv::FILLED);
  }
  return image;
}

/// The lower half is masked, and a slanted bar that no level of the pyramid is aligned with.
cv::Mat halfAndBar() {
  cv::Mat mask(480, 640, CV_8UC1, cv::Scalar(1));
  mask.rowRange(240, 480).setTo(0);
  cv::line(mask, {31, 17}, {607, 211}, cv::Scalar(0), 23);
  return mask;
}

/// Largest distance of a keypoint inside the masked part from the nearest pixel that may be used, pixels.
float deepest(const Features& features, const cv::Mat& mask) {
  cv::Mat distance;
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  float most = 0;
  for (const cv::KeyPoint& k : features.keypoints) {
    most = std::max(most, distance.at<float>(cvRound(k.pt.y), cvRound(k.pt.x)));
  }
  return most;
}

class ExtractorMask : public testing::TestWithParam<const char*> {
 protected:
  static FeatureExtractorOptions options() {
    FeatureExtractorOptions options;
    options.extractor = GetParam();
    options.features = 1000;
    return options;
  }
  Features extract(const cv::Mat& mask) {
    Features features;
    extractor_->extract(image_, features, mask);
    return features;
  }

  const cv::Mat image_ = texturedImage();
  const std::unique_ptr<FeatureExtractor> extractor_ = makeFeatureExtractor(options());
};
INSTANTIATE_TEST_SUITE_P(Extractors, ExtractorMask, testing::Values("simd_orb", "opencv"));

TEST_P(ExtractorMask, TakesNoKeypointUnderItAndAllThatAreAskedForElsewhere) {
  const cv::Mat mask = halfAndBar();
  const Features features = extract(mask);
  EXPECT_GE(features.size(), 0.99 * options().features);
  const bool ours = std::string(GetParam()) == "simd_orb";
  EXPECT_LE(deepest(features, mask), ours ? 0 : 3) << "cv::ORB: half a pixel of its highest level, along either axis";
}

TEST_P(ExtractorMask, MakesNoDifferenceWhereItMasksNothing) {
  const Features plain = extract(cv::Mat()), masked = extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(255)));
  ASSERT_EQ(plain.size(), masked.size());
  for (int i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(plain.keypoints[i].pt, masked.keypoints[i].pt);
    EXPECT_TRUE(
        std::equal(plain.descriptors.row(i), plain.descriptors.row(i) + kDescriptorBytes, masked.descriptors.row(i)));
  }
}

TEST_P(ExtractorMask, LeavesNothingWhereItMasksAll) { EXPECT_EQ(extract(cv::Mat::zeros(480, 640, CV_8UC1)).size(), 0); }

TEST_P(ExtractorMask, IsForgottenWithTheNextImage) {
  const Features before = extract(cv::Mat());
  extract(halfAndBar());
  EXPECT_EQ(extract(cv::Mat()).size(), before.size());
}

TEST_P(ExtractorMask, IsRefusedInAnotherSizeOrType) {
  EXPECT_THROW(extract(cv::Mat::zeros(240, 320, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(extract(cv::Mat::zeros(480, 640, CV_8UC3)), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
