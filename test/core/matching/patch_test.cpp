// The place where a patch is found again, in images whose every pixel is known exactly.
#include "matching/patch.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "support/random.h"

namespace gms_ransac {
namespace {

constexpr int kWidth = 120, kHeight = 100;
constexpr double kSpread = 3.4641;  // width of a uniform distribution of standard deviation 1

/// A smooth texture, defined between the pixels, too.
float texture(const Eigen::Vector2f& p) {
  return 128 + 40 * std::sin(0.45F * p.x() + 0.2F * p.y()) + 35 * std::cos(0.5F * p.y() - 0.15F * p.x()) +
         20 * std::sin(0.23F * p.x() * std::cos(0.05F * p.y()));
}

/// The texture at d from `from` is at `to.centre` + `to.shape` d here, times `gain` plus `offset`.
cv::Mat view(const Eigen::Vector2f& from, const PatchPlace& to, float gain = 1, float offset = 0, double noise = 0) {
  cv::Mat image(kHeight, kWidth, CV_8UC1);
  const Eigen::Matrix2f back = to.shape.inverse();
  Random random(7);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector2f here(static_cast<float>(x), static_cast<float>(y));
      const double value =
          gain * texture(from + back * (here - to.centre)) + offset + noise * kSpread * (random.uniform() - 0.5);
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(value);
    }
  }
  return image;
}

PatchPlace at(const Eigen::Vector2f& centre) {
  PatchPlace place;
  place.centre = centre;
  return place;
}

const Eigen::Vector2f kCentre(52.3F, 47.8F);

Patch taken(double noise = 0) {
  Patch patch;
  EXPECT_TRUE(patch.cut(view(kCentre, at(kCentre), 1, 0, noise), kCentre));
  return patch;
}

TEST(Patch, IsFoundToAHundredthOfAPixel) {
  const Patch patch = taken();
  for (const float shift : {0.F, 0.25F, -0.5F, 1.7F}) {
    const PatchPlace truth = at(kCentre + Eigen::Vector2f(shift, -0.6F * shift));
    const auto found = patch.find(view(kCentre, truth), at(kCentre), {3});
    ASSERT_TRUE(found);
    EXPECT_LT((found->centre - truth.centre).norm(), 0.02) << shift;
  }
}

TEST(Patch, IsFoundTurnedLeaningAndBrighter) {
  const Patch patch = taken();
  PatchPlace truth = at(kCentre + Eigen::Vector2f(0.8F, 0.5F));
  truth.shape << 1.1F, -0.12F, 0.15F, 0.95F;
  const auto found = patch.find(view(kCentre, truth, 0.7F, 30), at(kCentre), {3});
  ASSERT_TRUE(found);
  EXPECT_LT((found->centre - truth.centre).norm(), 0.03);
  EXPECT_LT((found->shape - truth.shape).norm(), 0.02);
}

TEST(Patch, NoiseMovesItByLittle) {
  const Patch patch = taken(3);
  const PatchPlace truth = at(kCentre + Eigen::Vector2f(-0.7F, 0.4F));
  const auto found = patch.find(view(kCentre, truth, 1, 0, 3), at(kCentre), {3});
  ASSERT_TRUE(found);
  EXPECT_LT((found->centre - truth.centre).norm(), 0.1);
}

TEST(Patch, IsNotFoundWhereItIsNot) {
  const Patch patch = taken();
  EXPECT_FALSE(patch.find(view(kCentre + Eigen::Vector2f(400, 900), at(kCentre)), at(kCentre), {3}));
  const cv::Mat plain(kHeight, kWidth, CV_8UC1, cv::Scalar(128));
  EXPECT_FALSE(patch.find(plain, at(kCentre), {3}));
  EXPECT_FALSE(patch.find(view(kCentre, at(kCentre + Eigen::Vector2f(1.7F, 0))), at(kCentre), {1}))
      << "beyond its reach";
  EXPECT_FALSE(Patch().cut(plain, kCentre));
}

TEST(Patch, StaysWithinTheImage) {
  const cv::Mat image = view(kCentre, at(kCentre));
  Patch patch;
  EXPECT_FALSE(patch.cut(image, {3, 50}));
  EXPECT_FALSE(patch.cut(image, {60, kHeight - 4}));
  EXPECT_FALSE(patch.cut(image, {NAN, 50}));
  EXPECT_FALSE(taken().find(image, at({kWidth - 4, 50}), {3}));
  EXPECT_FALSE(taken().find(image, at({NAN, 50}), {3}));
}

}  // namespace
}  // namespace gms_ransac
