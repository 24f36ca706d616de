// Copies, whole or in half of the rows, told from images that only look the same.
#include "input/image_copies.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "says.h"

namespace gms_ransac {
namespace {

sensor_msgs::Image measured(unsigned seed, const std::string& encoding = "mono8", size_t channels = 1) {
  sensor_msgs::Image image;
  image.width = 64;
  image.height = 48;
  image.step = static_cast<uint32_t>(image.width * channels);
  image.encoding = encoding;
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> grey(100, 103);
  for (size_t i = 0; i < image.step * image.height; ++i) image.data.push_back(static_cast<uint8_t>(grey(random)));
  return image;
}

/// Rows [from, to) of `image` become those of `source`, or one colour.
void setRows(int from, int to, const sensor_msgs::Image& source, sensor_msgs::Image& image) {
  std::copy(source.data.begin() + from * image.step, source.data.begin() + to * image.step,
            image.data.begin() + from * image.step);
}
void blacken(int from, int to, sensor_msgs::Image& image) {
  std::fill(image.data.begin() + from * image.step, image.data.begin() + to * image.step, uint8_t{0});
}

TEST(CopiedPart, OfTheSameImageIsAll) {
  const sensor_msgs::Image image = measured(1);
  EXPECT_TRUE(says(copiedPart(image, image), {"a copy of the image before it, bit for bit"}));
  EXPECT_EQ(copiedPart(image, measured(2)), "") << "the same scene, with noise of its own";
}

TEST(CopiedPart, OfATornImageIsHalfOfTheRows) {
  const sensor_msgs::Image before = measured(1);
  sensor_msgs::Image torn = measured(2);
  setRows(0, 23, before, torn);
  EXPECT_EQ(copiedPart(before, torn), "");
  setRows(23, 24, before, torn);
  EXPECT_TRUE(says(copiedPart(before, torn), {"24 of its 48 rows"}));
}

TEST(CopiedPart, RowsOfOneColourDoNotCount) {
  for (const auto& [encoding, channels] : {std::pair("mono8", 1), std::pair("bgr8", 3), std::pair("mono16", 2)}) {
    sensor_msgs::Image before = measured(1, encoding, channels), image = measured(2, encoding, channels);
    for (sensor_msgs::Image* each : {&before, &image}) blacken(0, 40, *each);
    EXPECT_EQ(copiedPart(before, image), "") << "a dark sky: " << encoding;
    setRows(40, 44, before, image);
    EXPECT_TRUE(says(copiedPart(before, image), {"4 of its 8 rows"})) << encoding;
    blacken(40, 48, before);
    EXPECT_EQ(copiedPart(before, before), "") << "a covered lens: " << encoding;
    before.data[20 * before.step] = before.data[30 * before.step] = 255;
    EXPECT_EQ(copiedPart(before, before), "") << "the same, with hot pixels: " << encoding;
  }
}

TEST(CopiedPart, OfAnImageThatIsStillCompressedIsAll) {
  sensor_msgs::Image before;
  before.encoding = "compressed: jpeg";
  EXPECT_EQ(copiedPart(before, before), "") << "it is empty";
  before.data = {1, 2, 3};
  sensor_msgs::Image image = before;
  EXPECT_TRUE(says(copiedPart(before, image), {"a copy of the image before it, bit for bit"}));
  image.data.back() = 4;
  EXPECT_EQ(copiedPart(before, image), "");
}

TEST(CopiedPart, OfAnotherKindOfImageIsNone) {
  const sensor_msgs::Image before = measured(1);
  sensor_msgs::Image other = before;
  other.encoding = "8UC1";
  EXPECT_EQ(copiedPart(before, other), "");
  other = before;
  other.height = 24;
  EXPECT_EQ(copiedPart(before, other), "");
}

TEST(CopiedPart, OfKeypointsIsTheirPositionsAndDescriptors) {
  Keypoints before;
  EXPECT_EQ(copiedPart(before, before), "") << "there are none";
  before.u = before.v = {10, 20};
  before.descriptors = {1, 2};
  Keypoints keypoints = before;
  EXPECT_TRUE(says(copiedPart(before, keypoints), {"its keypoints are a copy"}));
  keypoints.u[1] += 0.01f;
  EXPECT_EQ(copiedPart(before, keypoints), "");
}

}  // namespace
}  // namespace gms_ransac
