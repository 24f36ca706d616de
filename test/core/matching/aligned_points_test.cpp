// Points aligned between rendered images, against their exact places.
#include "matching/aligned_points.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "percentile.h"
#include "rendered_scene.h"

namespace gms_ransac {
namespace {

constexpr int kEarlier = 20, kCurrent = 22;

/// Pixels of the earlier image that the current one shows, and where, on a grid.
template <typename Visit>
void forEachExactPoint(const Visit& visit) {
  const cv::Size size = renderedScene().options().size;
  for (int y = 20; y < size.height - 20; y += 12) {
    for (int x = 20; x < size.width - 20; x += 12) {
      cv::Point2d exact;
      if (renderedScene().correspondence(kEarlier, cv::Point(x, y), kCurrent, exact)) visit(cv::Point(x, y), exact);
    }
  }
}

TEST(AlignedPoints, LieATenthOfAPixelFromTheirExactPlaces) {
  const cv::Mat &earlier = renderedFrame(kEarlier).image, &current = renderedFrame(kCurrent).image;
  const cv::Point2f keypoint_error(0.6F, -0.5F), in_earlier(0.3F, 0.2F);
  for (const PatchSearch& search : {kInNextImage, kInLaterImage}) {
    std::vector<double> off;
    int tried = 0;
    forEachExactPoint([&](const cv::Point& pixel, const cv::Point2d& exact) {
      ++tried;
      const PointToAlign point =
          pointToAlign(cv::Point2f(pixel) + in_earlier, cv::Point2f(exact) + keypoint_error + in_earlier, 1);
      EXPECT_EQ(point.pixel, pixel);
      const auto found = align(earlier, current, point, search);
      if (found) off.push_back(std::hypot(found->centre.x() - exact.x, found->centre.y() - exact.y));
    });
    EXPECT_GT(static_cast<double>(off.size()), 0.5 * tried);
    constexpr double kMedianOfDistance = 1.18;  // over the standard deviation of x and of y
    EXPECT_LT(median(off), 0.1 * kMedianOfDistance);
    RecordProperty("median_px", std::to_string(median(off)));
  }
}

/// The image, larger by a factor around the centre, as a sensor with noise sees it.
cv::Mat seenLarger(const cv::Mat& image, double factor, uint64_t seed) {
  const cv::Point2f centre(static_cast<float>(image.cols) / 2, static_cast<float>(image.rows) / 2);
  cv::Mat seen, noise(image.size(), CV_16SC1);
  cv::warpAffine(image, seen, cv::getRotationMatrix2D(centre, 0, factor), image.size());
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::add(seen, noise, seen, cv::noArray(), CV_8U);
  return seen;
}

TEST(AlignedPoints, ChangeTheirShapeWhereMoreThanChanceSpeaksForIt) {
  const cv::Mat& image = renderedFrame(kEarlier).image;
  const cv::Mat earlier = seenLarger(image, 1, 1);
  const cv::Point2f centre(static_cast<float>(image.cols) / 2, static_cast<float>(image.rows) / 2);
  for (const float factor : {1.F, 1.08F}) {
    const cv::Mat current = seenLarger(image, static_cast<double>(factor), 2);
    int found = 0, changed = 0;
    for (int y = 40; y < image.rows - 40; y += 12) {
      for (int x = 40; x < image.cols - 40; x += 12) {
        const cv::Point2f pixel(static_cast<float>(x), static_cast<float>(y));
        const PointToAlign point = pointToAlign(pixel, centre + factor * (pixel - centre), 1);
        const auto place = align(earlier, current, point, kInNextImage);
        found += place.has_value();
        changed += place && place->shape != Eigen::Matrix2f::Identity();
      }
    }
    ASSERT_GT(found, 300);
    if (factor == 1) {
      EXPECT_LT(changed, 0.02 * found);
    } else {
      EXPECT_GT(changed, 0.5 * found);
    }
    RecordProperty("changed_of_" + std::to_string(found), changed);
  }
}

TEST(AlignedPoints, AreNotFoundWhereTheImageShowsSomethingElse) {
  const cv::Mat &earlier = renderedFrame(kEarlier).image, &current = renderedFrame(kCurrent).image;
  int tried = 0, found = 0;
  forEachExactPoint([&](const cv::Point& pixel, const cv::Point2d& exact) {
    ++tried;
    const cv::Point2f elsewhere(static_cast<float>(exact.x) + 40, static_cast<float>(exact.y) - 25);
    found += align(earlier, current, pointToAlign(pixel, elsewhere, 1), kInNextImage).has_value();
  });
  EXPECT_LT(found, 0.15 * tried);
  // The rim of the image, and places that are none.
  EXPECT_FALSE(align(earlier, current, pointToAlign({2, 2}, {2, 2}, 1), kInNextImage));
  EXPECT_FALSE(align(earlier, current, pointToAlign({320, 240}, {-5000, 240}, 1), kInNextImage));
  EXPECT_FALSE(align(earlier, current, pointToAlign({-300, 240}, {320, 240}, 1), kInNextImage));
}

TEST(AlignedPoints, TheGuessIsMagnifiedAroundTheKeypoint) {
  const PointToAlign point = pointToAlign({100.4F, 50.3F}, {200, 80}, 1.5F);
  EXPECT_EQ(point.pixel, cv::Point(100, 50));
  EXPECT_NEAR(point.guess.centre.x(), 200 - 1.5 * 0.4, 1e-4);
  EXPECT_NEAR(point.guess.centre.y(), 80 - 1.5 * 0.3, 1e-4);
  EXPECT_FLOAT_EQ(point.guess.shape(0, 0), 1.5F);
  EXPECT_FLOAT_EQ(pointToAlign({}, {}, 100).guess.shape(1, 1), 2) << "no patch is followed farther";
}

TEST(AlignedPoints, AreSpreadWithTheOldestTracksFirst) {
  std::vector<cv::Point2f> points(10, {20, 20});  // a crowd
  points.push_back({300, 200});
  points.push_back({641, 481});  // outside
  const std::vector<uint32_t> tracks = {0, 9, 8, 7, 0, 0, 3, 4, 0, 10, 0, 0};
  EXPECT_EQ(spreadOut(points, tracks, {640, 480}), (std::vector<int>{3, 6, 7, 10, 11}));
  EXPECT_TRUE(spreadOut({}, {}, {640, 480}).empty());
}

}  // namespace
}  // namespace gms_ransac
