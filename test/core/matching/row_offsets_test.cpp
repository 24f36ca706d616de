// Rows that a calibration leaves off, learned from images whose every offset is known.
#include "matching/row_offsets.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

const cv::Size kSize(640, 240);
constexpr float kDisparityOfAll = 12;

cv::Mat leftImage() {
  cv::Mat image(kSize, CV_8UC1);
  cv::theRNG().state = 3;
  cv::randu(image, 0, 256);
  cv::GaussianBlur(image, image, {}, 1.5);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

std::vector<cv::Point2f> somePoints() {
  std::vector<cv::Point2f> points;
  for (int i = 0; i < 1500; ++i)
    points.emplace_back(60 + static_cast<float>(i * 37 % 520), 20 + static_cast<float>(i * 53 % 200));
  return points;
}

/// Learns from some images whose right one shows all lower by offset(point).
template <typename Offset>
RowOffsets learned(const Offset& offset) {
  const cv::Mat left = leftImage();
  cv::Mat_<cv::Vec2f> map(kSize);
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      const auto u = static_cast<float>(x) + kDisparityOfAll, v = static_cast<float>(y);
      map(y, x) = {u, v - static_cast<float>(offset(cv::Point2f(u, v)))};
    }
  }
  cv::Mat right;
  cv::remap(left, right, map, cv::noArray(), cv::INTER_CUBIC);
  RowSearch search;
  search.setImages(left, right, 0);
  RowOffsets offsets;
  for (int image = 0; image < 5; ++image) offsets.measure(left, right, somePoints(), search);
  return offsets;
}

TEST(RowOffsets, LearnATurnedAndRolledCamera) {
  const auto offset = [](const cv::Point2f& p) {
    const double x = (p.x - 320) / 320, y = (p.y - 120) / 320;
    return 0.2 - 0.6 * x + 1.2 * x * y;
  };
  const RowOffsets offsets = learned(offset);
  for (const cv::Point2f& point : somePoints()) EXPECT_NEAR(offsets.at(point), offset(point), 0.1) << point;
}

TEST(RowOffsets, FollowTheCornersOfAWideImage) {
  // KITTI's right images: 1.5 px in the corners, with opposite signs.
  const auto offset = [](const cv::Point2f& p) { return -0.15 + 1.5 * (p.x / 320 - 1) * (p.y / 120 - 1); };
  const RowOffsets offsets = learned(offset);
  for (const cv::Point2f& point : somePoints()) EXPECT_NEAR(offsets.at(point), offset(point), 0.1) << point;
}

TEST(RowOffsets, TellTheDisparitiesOfARolledCamera) {
  const CameraIntrinsics k = {320, 320, 310, 124, "", {}};
  const double roll = 0.003;
  // Rotated exactly.
  const auto seen = [&](const cv::Point2f& p) -> Eigen::Vector2d {
    return Eigen::Rotation2Dd(-roll) * Eigen::Vector2d(p.x - k.cx, p.y - k.cy) -
           Eigen::Vector2d(p.x - k.cx, p.y - k.cy);
  };
  const RowOffsets offsets = learned([&](const cv::Point2f& p) { return seen(p).y(); });
  for (const cv::Point2f& point : somePoints())
    EXPECT_NEAR(offsets.disparityError(point, k), -seen(point).x(), 0.03) << point;
}

TEST(RowOffsets, TellTheDisparitiesOfAWrongCentreOfDistortion) {
  const CameraIntrinsics k = {320, 320, 310, 124, "", {}};
  const double decentred = 1.5;  // k1 times the error of the centre, pixels; x and y at depth 1 (Brown 1966)
  const auto ray = [&](const cv::Point2f& p) { return Eigen::Vector2d((p.x - k.cx) / k.fx, (p.y - k.cy) / k.fy); };
  const RowOffsets offsets = learned([&](const cv::Point2f& p) { return 2 * decentred * ray(p).prod(); });
  for (const cv::Point2f& point : somePoints()) {
    const Eigen::Vector2d r = ray(point);
    const double shift = decentred * (3 * r.x() * r.x() + r.y() * r.y());
    // The other part grows with x^2 + y^2.
    EXPECT_NEAR(offsets.disparityError(point, k), 3 * decentred * r.squaredNorm() - shift, 0.03) << point;
  }
}

TEST(RowOffsets, AreNoneOfRectifiedImages) {
  const RowOffsets offsets = learned([](const cv::Point2f&) { return 0.; });
  for (const cv::Point2f& point : somePoints()) EXPECT_NEAR(offsets.at(point), 0, 0.05) << point;
}

TEST(RowOffsets, LeaveWrongRectificationsToTheDoubt) {
  const RowOffsets offsets = learned([](const cv::Point2f&) { return 2.; });
  for (const cv::Point2f& point : somePoints()) EXPECT_EQ(offsets.at(point), 0) << point;
}

}  // namespace
}  // namespace gms_ransac
