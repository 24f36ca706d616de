// ~features: what each estimator reads where, and which images the tracks can do without.
#include "output/feature_stream.h"

#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>
#include <opencv2/imgproc.hpp>

#include "output/point_messages.h"
#include "processor_stream.h"

namespace gms_ransac {
namespace {

constexpr int kWidth = 640, kHeight = 480;

/// Corners everywhere, moved by so many pixels.
cv::Mat view(int shift) {
  cv::Mat noise(kHeight / 5, kWidth / 5 + 100, CV_8UC1), texture;
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::resize(noise, texture, cv::Size(), 5, 5, cv::INTER_NEAREST);
  return texture(cv::Rect(shift, 0, kWidth, kHeight)).clone();
}

const cv::Mat& darkness() {
  static const cv::Mat dark = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  return dark;
}

Parameters calibrated() {
  Parameters parameters;
  parameters.camera = {500, 500, 319.5, 239.5, "", {}};
  return parameters;
}

ImageWithInfo input(const cv::Mat& grey, double stamp) {
  ImageWithInfo image;
  image.image = imageMessage(grey, stamp);
  image.received = ros::Time(stamp);
  return image;
}

// The messages as the estimators read them.

class Layout : public ::testing::Test {
 protected:
  Layout() {
    feature_.id = (1U << 24) + 77;
    feature_.pixel = {300, 200};
    feature_.ray = {0.25, -0.5};
    feature_.velocity = {0.125, -2};
    current_.header.stamp = ros::Time(12, 34);
    current_.depth = cv::Mat::zeros(kHeight, kWidth, CV_32FC1);
  }

  sensor_msgs::PointCloud message(FeatureLayout layout) const { return featureMessage(current_, {feature_}, layout); }
  static float channel(const sensor_msgs::PointCloud& cloud, size_t index) {
    return cloud.channels.at(index).values.at(0);
  }

  /// x, y, z and the stamp are the same in all.
  static void expectRay(const sensor_msgs::PointCloud& cloud) {
    ASSERT_EQ(cloud.points.size(), 1U);
    EXPECT_EQ(cloud.points[0].x, 0.25F);
    EXPECT_EQ(cloud.points[0].y, -0.5F);
    EXPECT_EQ(cloud.points[0].z, 1) << "all of them end their process otherwise";
    EXPECT_EQ(cloud.header.stamp, ros::Time(12, 34));
  }

  PreparedFrame current_;
  Feature feature_;
};

TEST_F(Layout, OfVinsMono) {
  const sensor_msgs::PointCloud cloud = message(FeatureLayout::kVinsMono);
  expectRay(cloud);
  ASSERT_EQ(cloud.channels.size(), 5U);
  const int v = static_cast<int>(channel(cloud, 0) + 0.5), number_of_cameras = 1;
  EXPECT_EQ(v / number_of_cameras, 77) << "feature_id";
  EXPECT_EQ(v % number_of_cameras, 0) << "camera_id";
  EXPECT_EQ(channel(cloud, 1), 300) << "p_u";
  EXPECT_EQ(channel(cloud, 2), 200) << "p_v";
  EXPECT_EQ(channel(cloud, 3), 0.125F) << "velocity_x";
  EXPECT_EQ(channel(cloud, 4), -2) << "velocity_y";
}

TEST_F(Layout, OfVinsFusion) {
  const sensor_msgs::PointCloud cloud = message(FeatureLayout::kVinsFusion);
  expectRay(cloud);
  ASSERT_EQ(cloud.channels.size(), 9U) << "with more than five it reads nine";
  EXPECT_EQ(static_cast<int>(channel(cloud, 0)), 77) << "feature_id";
  EXPECT_EQ(static_cast<int>(channel(cloud, 1)), 0) << "camera_id";
  EXPECT_EQ(channel(cloud, 2), 300) << "p_u";
  EXPECT_EQ(channel(cloud, 3), 200) << "p_v";
  EXPECT_EQ(channel(cloud, 4), 0.125F) << "velocity_x";
  EXPECT_EQ(channel(cloud, 5), -2) << "velocity_y";
  for (const size_t i : {6, 7, 8}) EXPECT_EQ(channel(cloud, i), 0) << "gx, gy, gz: a known position, for a display";
}

TEST_F(Layout, OfLviSam) {
  current_.depth.at<float>(200, 300) = 4;
  const sensor_msgs::PointCloud cloud = message(FeatureLayout::kLviSam);
  expectRay(cloud);
  ASSERT_EQ(cloud.channels.size(), 6U);
  EXPECT_EQ(static_cast<int>(channel(cloud, 0) + 0.5), 77) << "feature_id";
  EXPECT_EQ(channel(cloud, 1), 300) << "p_u";
  EXPECT_EQ(channel(cloud, 2), 200) << "p_v";
  EXPECT_EQ(channel(cloud, 3), 0.125F) << "velocity_x";
  EXPECT_EQ(channel(cloud, 4), -2) << "velocity_y";
  EXPECT_EQ(channel(cloud, 5), 4) << "depth, along the optical axis";
}

TEST_F(Layout, OfLviSamWithoutDepth) {
  EXPECT_EQ(channel(message(FeatureLayout::kLviSam), 5), -1);
  current_.depth.release();
  EXPECT_EQ(channel(message(FeatureLayout::kLviSam), 5), -1);
}

// Images that are skipped.

/// The node's worker with one listener, that of ~features.
class FeaturesAlone {
 public:
  explicit FeaturesAlone(double rate, InputKind kind = InputKind::kStream)
      : processor_(calibrated(), "image", "camera_info"), stream_(kind) {
    options_.rate = rate;
    processor_.setOptions(ProcessorOptions());
  }

  /// True when the image is passed over.
  bool passes(const cv::Mat& grey, double stamp, bool reset = false) {
    if (reset) processor_.requestReset();
    auto frame = processor_.prepare(input(grey, stamp), Extraction::kPutOff);
    if (stream_.passesOver(*frame, options_)) {
      processor_.passOver(std::move(frame));
      return true;
    }
    const ProcessedFrame processed = processor_.process(std::move(frame));
    status_ = processed.status;
    if (auto features = stream_.next(processed, options_)) messages_[stamp] = std::move(*features);
    return false;
  }
  /// Numbers of the images that are compared, from a camera that rotates steadily.
  std::vector<int> compared(int images, double period) {
    std::vector<int> numbers;
    for (int i = 0; i < images; ++i) {
      if (!passes(view(3 * i), 100 + period * i)) numbers.push_back(i);
    }
    return numbers;
  }

  const std::map<double, std::vector<Feature>>& messages() const { return messages_; }
  uint8_t status() const { return status_; }

 private:
  FrameProcessor processor_;
  FeatureStream stream_;
  FeatureOptions options_;
  std::map<double, std::vector<Feature>> messages_;
  uint8_t status_ = 0;
};

TEST(PassingOver, LeavesTheImagesThatCarryAMessage) {
  FeaturesAlone node(10);
  // The second is the first that has features; from there on every second one at 20 Hz.
  EXPECT_EQ(node.compared(10, 0.05), (std::vector<int>{0, 1, 3, 5, 7, 9}));
  EXPECT_EQ(node.messages().size(), 5U);
  const std::vector<Feature>&first = node.messages().begin()->second, &last = node.messages().rbegin()->second;
  std::map<uint32_t, cv::Point2f> before;
  for (const Feature& feature : first) before[feature.id] = feature.pixel;
  int kept = 0;
  for (const Feature& feature : last) {
    const auto same = before.find(feature.id);
    if (same == before.end()) continue;
    ++kept;
    EXPECT_NEAR(same->second.x - feature.pixel.x, 3 * 8, 0.2);
    EXPECT_NEAR(same->second.y, feature.pixel.y, 0.2);
  }
  EXPECT_GT(kept, 0.8 * static_cast<double>(first.size()));
}

TEST(PassingOver, ComparesSixTimesASecondHoweverFewMessagesAreAskedFor) {
  EXPECT_EQ(FeaturesAlone(2).compared(12, 0.05), (std::vector<int>{0, 1, 4, 7, 10}));
  // One more would leave 0.2 s between them.
  EXPECT_EQ(FeaturesAlone(2).compared(6, 0.1), (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

TEST(PassingOver, NoneWhereEveryImageCarriesAMessage) { EXPECT_EQ(FeaturesAlone(0).compared(6, 0.05).size(), 6U); }

TEST(PassingOver, NoneOfAPair) {
  FeaturesAlone node(10, InputKind::kPair);
  EXPECT_EQ(node.compared(6, 0.05).size(), 6U);
}

TEST(PassingOver, NoneAfterAnImageOfNoUse) {
  FeaturesAlone node(10);
  ASSERT_EQ(node.compared(4, 0.05), (std::vector<int>{0, 1, 3}));
  EXPECT_TRUE(node.passes(view(12), 100.20));
  EXPECT_FALSE(node.passes(darkness(), 100.25)) << "a message was due";
  EXPECT_EQ(node.status(), MatchStats::TOO_FEW_KEYPOINTS);
  EXPECT_FALSE(node.passes(view(18), 100.30)) << "and is still";
  EXPECT_NE(node.status(), MatchStats::TOO_FEW_KEYPOINTS);
  EXPECT_TRUE(node.passes(view(21), 100.33));
}

TEST(PassingOver, NoneThatAsksForANewStart) {
  FeaturesAlone node(10);
  ASSERT_EQ(node.compared(4, 0.05), (std::vector<int>{0, 1, 3}));
  EXPECT_FALSE(node.passes(view(12), 100.2, true)) << "a reset was asked for";
  EXPECT_EQ(node.status(), MatchStats::FIRST_FRAME);
  FeaturesAlone other(10);
  ASSERT_EQ(other.compared(4, 0.05), (std::vector<int>{0, 1, 3}));
  EXPECT_FALSE(other.passes(view(12), 90)) << "the stamps went back";
  EXPECT_EQ(other.status(), MatchStats::TIME_RESET);
}

TEST(PassingOver, FeaturesThatWerePutOffAreTheSame) {
  FrameProcessor now(calibrated(), "image", "camera_info"), later(calibrated(), "image", "camera_info");
  for (FrameProcessor* processor : {&now, &later}) processor->setOptions(ProcessorOptions());
  for (int i = 0; i < 3; ++i) {
    const ImageWithInfo image = input(view(5 * i), 100 + 0.1 * i);
    const ProcessedFrame a = now.process(now.prepare(image));
    const ProcessedFrame b = later.process(later.prepare(image, Extraction::kPutOff));
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.text, b.text);
    if (i == 0) continue;
    EXPECT_EQ(a.result->inliers, b.result->inliers);
    EXPECT_EQ(*a.track_ids, *b.track_ids);
  }
}

}  // namespace
}  // namespace gms_ransac
