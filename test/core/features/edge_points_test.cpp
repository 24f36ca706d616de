// Edge points against drawn edges and corners, and the extractor on an image that has little else.
#include "features/corner_detector.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "gms_ransac/feature_extractor.h"

namespace gms_ransac {
namespace {

constexpr int kSide = 200;

/// A bright half plane whose edge runs through the middle at `degrees`, smoothed as a lens does.
cv::Mat edge(double degrees) {
  cv::Mat image(kSide, kSide, CV_8UC1);
  const double x = std::sin(degrees * CV_PI / 180), y = std::cos(degrees * CV_PI / 180);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      image.at<uint8_t>(v, u) = (u - kSide / 2) * x + (v - kSide / 2) * y > 0 ? 140 : 90;
    }
  }
  cv::GaussianBlur(image, image, cv::Size(), 0.8);
  return image;
}

bool isKept(const cv::Mat& image, int x, int y) {
  Plane plane;
  plane.resize(image.cols, image.rows);
  for (int row = 0; row < image.rows; ++row) std::copy_n(image.ptr(row), image.cols, plane.row(row));
  std::vector<Corner> corners = {{static_cast<uint16_t>(x), static_cast<uint16_t>(y), 20, 20}};
  removeEdgePoints(plane, corners);
  return !corners.empty();
}

TEST(EdgePoints, StraightEdgeOfAnyDirectionIsRemoved) {
  for (double degrees : {0.0, 7.0, 22.5, 45.0, 80.0, 90.0, 133.0}) {
    EXPECT_FALSE(isKept(edge(degrees), kSide / 2, kSide / 2)) << degrees << " degrees";
  }
}

TEST(EdgePoints, CornersEndsAndSpotsAreKept) {
  const cv::Mat plain(kSide, kSide, CV_8UC1, cv::Scalar(60));
  cv::Mat corner = plain.clone(), end = plain.clone(), spot = plain.clone();
  cv::rectangle(corner, {100, 100, 80, 80}, cv::Scalar(200), cv::FILLED);
  cv::line(end, {20, 100}, {100, 100}, cv::Scalar(200), 3);
  cv::circle(spot, {100, 100}, 3, cv::Scalar(200), cv::FILLED);
  for (const cv::Mat& image : {corner, end, spot}) EXPECT_TRUE(isKept(image, 100, 100));
}

TEST(EdgePoints, StrongestContrastDoesNotOverflow) {
  cv::Mat stripes(kSide, kSide, CV_8UC1);
  for (int x = 0; x < kSide; ++x) stripes.col(x) = x % 4 < 2 ? 0 : 255;
  EXPECT_FALSE(isKept(stripes, 100, 100));
  EXPECT_FALSE(isKept(stripes.t(), 100, 100));
  cv::Mat checks = stripes ^ stripes.t();
  EXPECT_TRUE(isKept(checks, 100, 100));
}

TEST(EdgePoints, SparseImageYieldsItsCornersAlone) {
  // A dark box, rotated a little, on a bright floor; the artefacts of JPEG make FAST fire all along its sides.
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(150));
  const cv::RotatedRect box({320, 240}, {240, 160}, 11);
  cv::Point2f ends[4];
  box.points(ends);
  std::vector<cv::Point> polygon(ends, ends + 4);
  cv::fillConvexPoly(image, polygon, cv::Scalar(50));
  cv::GaussianBlur(image, image, cv::Size(), 0.6);
  std::vector<uchar> file;
  cv::imencode(".jpg", image, file, {cv::IMWRITE_JPEG_QUALITY, 75});
  image = cv::imdecode(file, cv::IMREAD_GRAYSCALE);

  FeatureExtractorOptions options;
  options.extractor = "simd_orb";
  Features features;
  makeFeatureExtractor(options)->extract(image, features);
  const auto distanceToEnd = [&](const cv::KeyPoint& keypoint) {
    double nearest = 1e9;
    for (const cv::Point2f& end : ends) nearest = std::min(nearest, cv::norm(end - keypoint.pt));
    return nearest;
  };
  std::vector<cv::KeyPoint> everywhere;
  cv::FAST(image, everywhere, 7);
  ASSERT_GT(std::count_if(everywhere.begin(), everywhere.end(), [&](const auto& k) { return distanceToEnd(k) > 30; }),
            20);
  ASSERT_GE(features.size(), 4);
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    const double nearest = distanceToEnd(keypoint);
    const double reach = (kEdgeRadius + 2) * std::pow(options.pyramid_scale, keypoint.octave) * std::sqrt(2.0);
    EXPECT_LT(nearest, reach) << "a keypoint at " << keypoint.pt << " on level " << keypoint.octave;
  }
}

}  // namespace
}  // namespace gms_ransac
