// ~features: what each estimator reads where, and which images the tracks can do without.
#include "output/feature_stream.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "output/point_messages.h"
#include "processor_stream.h"

namespace gms_ransac {
namespace {

constexpr int kWidth = 640, kHeight = 480;

const cv::Mat& darkness() {
  static const cv::Mat dark = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  return dark;
}

ImageWithInfo input(const cv::Mat& grey, double stamp) {
  ImageWithInfo image;
  image.image = imageMessage(grey, stamp);
  image.received = ros::Time(stamp);
  return image;
}

TEST(FeatureMessage, EachEstimatorFindsWhatItReads) {
  Feature feature;
  feature.id = (1U << 24) + 77;
  feature.pixel = {300, 200};
  feature.ray = {0.25, -0.5};
  feature.velocity = {0.125, -2};
  PreparedFrame current;
  current.image.header.stamp = ros::Time(12, 34);
  const cv::Mat hole = cv::Mat::zeros(kHeight, kWidth, CV_32FC1), known = hole + 4;
  struct Case {
    FeatureLayout layout;
    cv::Mat depth;
    std::vector<std::pair<std::string, float>> channels;
  };
  // VINS-Fusion reads nine channels where there are more than five; the last three are a known position, for a display.
  const auto lvi_sam = [](float depth) -> std::vector<std::pair<std::string, float>> {
    return {{"id", 77}, {"u", 300}, {"v", 200}, {"velocity_x", 0.125F}, {"velocity_y", -2}, {"depth", depth}};
  };
  for (const Case& c :
       {Case{FeatureLayout::kVinsMono,
             {},
             {{"id", 77}, {"u", 300}, {"v", 200}, {"velocity_x", 0.125F}, {"velocity_y", -2}}},
        Case{FeatureLayout::kVinsFusion,
             {},
             {{"id", 77},
              {"camera_id", 0},
              {"u", 300},
              {"v", 200},
              {"velocity_x", 0.125F},
              {"velocity_y", -2},
              {"gx", 0},
              {"gy", 0},
              {"gz", 0}}},
        Case{FeatureLayout::kLviSam, known, lvi_sam(4)}, Case{FeatureLayout::kLviSam, hole, lvi_sam(-1)},
        Case{FeatureLayout::kLviSam, {}, lvi_sam(-1)}}) {
    current.depth = c.depth;
    const sensor_msgs::PointCloud cloud = featureMessage(current, {feature}, c.layout);
    EXPECT_EQ(cloud.header.stamp, ros::Time(12, 34));
    ASSERT_EQ(cloud.points.size(), 1U);
    EXPECT_EQ(cloud.points[0].x, 0.25F);
    EXPECT_EQ(cloud.points[0].y, -0.5F);
    EXPECT_EQ(cloud.points[0].z, 1) << "all of them end their process otherwise";
    std::vector<std::pair<std::string, float>> channels;
    for (const auto& channel : cloud.channels) channels.emplace_back(channel.name, channel.values.at(0));
    EXPECT_EQ(channels, c.channels);
  }
}

// Images that are skipped.

Wanted featuresAlone() {
  Wanted wanted;
  wanted.features = wanted.features_alone = true;
  return wanted;
}

/// The node's worker with one listener, that of ~features. `others`: they have one too, and no image is passed over.
class FeaturesAlone {
 public:
  explicit FeaturesAlone(double rate, InputKind kind = InputKind::kStream, bool others = false)
      : processor_(calibrated()), stream_(kind), others_(others) {
    options_.rate = rate;
  }

  void setRate(double rate) { options_.rate = rate; }
  /// True when the image is passed over.
  bool passes(const cv::Mat& grey, double stamp, bool reset = false) {
    if (reset) processor_.requestReset();
    Received received = processor_.receive(input(grey, stamp), featuresAlone());
    if (!others_ && stream_.skips(received, options_)) return true;
    const ProcessedFrame processed = processor_.process(processor_.prepare(std::move(received)));
    status_ = processed.status;
    if (auto features = stream_.next(processed, options_)) messages_[stamp] = std::move(*features);
    return false;
  }
  /// Numbers of the images that are compared, from a camera that rotates steadily.
  std::vector<int> compared(int images, double period) {
    std::vector<int> numbers;
    for (int i = 0; i < images; ++i) {
      if (!passes(cornersMovedBy(3 * i), 100 + period * i)) numbers.push_back(i);
    }
    return numbers;
  }

  const std::map<double, std::vector<Feature>>& messages() const { return messages_; }
  uint8_t status() const { return status_; }

 private:
  Processor processor_;
  FeatureStream stream_;
  const bool others_;
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

TEST(FeatureStream, MessagesKeepTheBeatAndTracksSpanTheImagesBetween) {
  FeaturesAlone node(10, InputKind::kStream, true);
  node.compared(20, 0.04);
  std::vector<int> images;
  const std::vector<Feature>* before = nullptr;
  double before_stamp = 0;
  std::set<uint32_t> ever;
  for (const auto& [stamp, features] : node.messages()) {
    images.push_back(cvRound((stamp - 100) / 0.04));
    EXPECT_GT(features.size(), 100u);
    EXPECT_LE(features.size(), 220u) << "~feature_limit";
    size_t kept = 0;
    for (const Feature& feature : features) {
      const auto same = [&](const Feature& each) { return each.id == feature.id; };
      const auto last = before ? std::find_if(before->begin(), before->end(), same) : features.end();
      const bool known = before && last != before->end();
      EXPECT_EQ(ever.insert(feature.id).second, !known) << "an id came back";
      if (!known) continue;
      ++kept;
      EXPECT_LT((feature.velocity - (feature.ray - last->ray) / (stamp - before_stamp)).norm(), 1e-9);
      EXPECT_NEAR(feature.age, last->age + stamp - before_stamp, 1e-9);
    }
    if (before) {
      EXPECT_GT(static_cast<double>(kept), 0.85 * static_cast<double>(before->size()));
    }
    before = &features;
    before_stamp = stamp;
  }
  EXPECT_EQ(images, (std::vector<int>{1, 4, 6, 9, 11, 14, 16, 19}));
}

TEST(FeatureStream, ARateTakesEffectWithTheNextImage) {
  FeaturesAlone node(0.1, InputKind::kStream, true);
  node.compared(4, 0.05);
  EXPECT_EQ(node.messages().size(), 1u);
  node.setRate(10);
  node.passes(cornersMovedBy(12), 100.2);
  EXPECT_EQ(node.messages().count(100.2), 1u) << "not ten seconds after the last";
  node.passes(cornersMovedBy(15), 100.25);
  node.passes(cornersMovedBy(18), 100.3);
  EXPECT_EQ(node.messages().size(), 3u);
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
  EXPECT_TRUE(node.passes(cornersMovedBy(12), 100.20));
  EXPECT_FALSE(node.passes(darkness(), 100.25)) << "a message was due";
  EXPECT_EQ(node.status(), MatchStats::TOO_FEW_KEYPOINTS);
  EXPECT_FALSE(node.passes(cornersMovedBy(18), 100.30)) << "and is still";
  EXPECT_NE(node.status(), MatchStats::TOO_FEW_KEYPOINTS);
  EXPECT_TRUE(node.passes(cornersMovedBy(21), 100.33));
}

TEST(PassingOver, NoneThatAsksForANewStart) {
  FeaturesAlone node(10);
  ASSERT_EQ(node.compared(4, 0.05), (std::vector<int>{0, 1, 3}));
  EXPECT_FALSE(node.passes(cornersMovedBy(12), 100.2, true)) << "a reset was asked for";
  EXPECT_EQ(node.status(), MatchStats::FIRST_FRAME);
  FeaturesAlone other(10);
  ASSERT_EQ(other.compared(4, 0.05), (std::vector<int>{0, 1, 3}));
  EXPECT_FALSE(other.passes(cornersMovedBy(12), 90)) << "the stamps went back";
  EXPECT_EQ(other.status(), MatchStats::TIME_RESET);
}

TEST(PassingOver, FeaturesThatWerePutOffAreTheSame) {
  Processor now(calibrated()), later(calibrated());
  for (int i = 0; i < 3; ++i) {
    const ImageWithInfo image = input(cornersMovedBy(5 * i), 100 + 0.1 * i);
    const ProcessedFrame a = now.ask(image);
    const ProcessedFrame b = later.process(later.prepare(later.receive(image, featuresAlone())));
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.text, b.text);
    if (i == 0) continue;
    EXPECT_EQ(a.pair->result.inliers, b.pair->result.inliers);
    EXPECT_EQ(a.pair->track_ids, b.pair->track_ids);
  }
}

}  // namespace
}  // namespace gms_ransac
