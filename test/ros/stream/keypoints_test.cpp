// ~input keypoints without a graph: features of a message, its depth, a mask over them, and what is refused.
#include "input/keypoints_conversion.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

#include "output/message_conversion.h"
#include "processor_stream.h"
#include "says.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

constexpr int kPoints = 400, kNumbers = 64;

/// The two messages of a drawn scene, with floats as descriptors.
struct Messages {
  TwoViewScene scene;
  Keypoints reference, current;

  Messages() {
    TwoViewSceneOptions options;
    options.matches = kPoints;
    options.outlier_ratio = 0;
    options.noise_px = 0.2;
    scene = makeTwoViewScene(options);
    cv::Mat rows(kPoints, kNumbers, CV_32F);
    cv::RNG(1).fill(rows, cv::RNG::NORMAL, 0, 1);
    for (Keypoints* message : {&reference, &current}) {
      message->width = 640;
      message->height = 480;
      message->scale_factor = 2;
      message->descriptor_type = Keypoints::DESCRIPTOR_FLOAT32;
      message->descriptor_size = kNumbers * sizeof(float);
      message->descriptors.assign(rows.data, rows.data + rows.total() * rows.elemSize());
    }
    reference.header.stamp = ros::Time(1.0);
    current.header.stamp = ros::Time(1.1);
    const PointPairs& pairs = scene.pairs;
    for (size_t i = 0; i < kPoints; ++i) {  // noise moved some out of the image
      reference.u.push_back(std::clamp(pairs.x_reference[i], 0.f, 639.f));
      reference.v.push_back(std::clamp(pairs.y_reference[i], 0.f, 479.f));
      current.u.push_back(std::clamp(pairs.x_current[i], 0.f, 639.f));
      current.v.push_back(std::clamp(pairs.y_current[i], 0.f, 479.f));
    }
    for (const Eigen::Vector3d& point : scene.points) {
      reference.depth.push_back(static_cast<float>(point.z()));
      current.depth.push_back(static_cast<float>((scene.R * point + scene.t).z()));
    }
  }
};

struct KeypointsNode : Processor {
  explicit KeypointsNode(ScaleMode scale = ScaleMode::kUnit) : Processor(parametersFor(scale)) {}
  static Parameters parametersFor(ScaleMode scale) {
    Parameters parameters = calibrated(scale, sceneCamera().intrinsics());
    parameters.input = InputKind::kKeypoints;
    return parameters;
  }
  ProcessedFrame ask(const Keypoints& message, const sensor_msgs::ImageConstPtr& mask = nullptr) {
    const auto image = boost::make_shared<sensor_msgs::Image>();
    image->header = message.header;
    ImageWithInfo input;
    input.image = image;
    input.keypoints = boost::make_shared<Keypoints>(message);
    input.mask = mask;
    input.received = message.header.stamp;
    return Processor::ask(input);
  }
};

TEST(KeypointsInput, IsAnsweredAsImagesAre) {
  const Messages messages;
  KeypointsNode node;
  EXPECT_EQ(node.ask(messages.reference).status, MatchStats::FIRST_FRAME);
  const ProcessedFrame answer = node.ask(messages.current);
  ASSERT_EQ(answer.status, MatchStats::OK) << answer.text;
  EXPECT_LT(directionError(answer.pose.t, messages.scene.currentInReference().translation()), 1);
  EXPECT_FALSE(answer.metric_scale);
  Keypoints published;
  toMessage(answer, published);
  EXPECT_EQ(published.descriptor_type, Keypoints::DESCRIPTOR_FLOAT32);
  EXPECT_EQ(published.descriptors, messages.current.descriptors);
  EXPECT_EQ(published.depth.size(), 0u) << "only with ~scale depth";
}

TEST(KeypointsInput, NegativeAnglesAreThoseBeyondHalfACircle) {
  Messages messages;
  for (size_t i = 0; i < kPoints; ++i) messages.reference.angle.push_back(0.9f * static_cast<float>(i) - 180);
  Features features;
  EXPECT_EQ(toFeatures(messages.reference, features), "");
  for (size_t i = 0; i < kPoints; ++i) {
    const float angle = messages.reference.angle[i];
    EXPECT_EQ(features.keypoints[i].angle, angle < 0 ? angle + 360 : angle);
  }
}

TEST(KeypointsInput, DepthOfTheMessageGivesMetres) {
  Messages messages;
  messages.reference.depth[0] = std::numeric_limits<float>::quiet_NaN();
  messages.current.depth[1] = -1;
  KeypointsNode node(ScaleMode::kDepth);
  node.ask(messages.reference);
  const ProcessedFrame answer = node.ask(messages.current);
  ASSERT_EQ(answer.status, MatchStats::OK) << answer.text;
  ASSERT_TRUE(answer.metric_scale) << answer.text;
  EXPECT_LT((answer.pose.t - messages.scene.currentInReference().translation()).norm(), 0.02);
  messages.current.depth.clear();
  messages.current.header.stamp = ros::Time(1.2);
  KeypointsNode without(ScaleMode::kDepth);
  messages.reference.depth.clear();
  without.ask(messages.reference);
  EXPECT_TRUE(says(without.ask(messages.current).text, {"no length: the keypoints have no depth"}));
}

TEST(KeypointsInput, AMaskDropsTheKeypointsItCovers) {
  const Messages messages;
  KeypointsNode node(ScaleMode::kDepth);
  cv::Mat mask = cv::Mat::zeros(480, 640, CV_8UC1);
  mask.colRange(0, 400) = 1;
  const sensor_msgs::ImageConstPtr message = imageMessage(mask, 0);
  node.ask(messages.reference, message);
  const ProcessedFrame answer = node.ask(messages.current, message);
  Keypoints published;
  toMessage(answer, published);
  ASSERT_GT(published.u.size(), 100u);
  ASSERT_EQ(published.depth.size(), published.u.size());
  size_t k = 0;
  for (size_t i = 0; i < kPoints; ++i) {
    if (messages.current.u[i] >= 399.5f) continue;
    ASSERT_LT(k, published.u.size());
    EXPECT_EQ(published.u[k], messages.current.u[i]);
    EXPECT_EQ(published.depth[k], messages.current.depth[i]);
    const size_t bytes = published.descriptor_size;
    EXPECT_TRUE(std::equal(&published.descriptors[k * bytes], &published.descriptors[k * bytes] + bytes,
                           &messages.current.descriptors[i * bytes]));
    ++k;
  }
  EXPECT_EQ(k, published.u.size());
  Messages later;
  later.current.header.stamp = ros::Time(1.2);
  later.current.u[0] = 20;  // or it would be a copy
  const ProcessedFrame nothing = node.ask(later.current, imageMessage(cv::Mat::zeros(480, 640, CV_8UC1), 0));
  EXPECT_EQ(nothing.status, MatchStats::TOO_FEW_KEYPOINTS) << nothing.text;
}

TEST(KeypointsInput, TooFewAreNoFaultOfTheOptions) {
  Messages messages;
  Keypoints few;
  few.header.stamp = ros::Time(1.1);
  few.width = 640;
  few.height = 480;
  few.scale_factor = 2;
  KeypointsNode node;
  node.ask(messages.reference);
  const ProcessedFrame answer = node.ask(few);
  EXPECT_EQ(answer.status, MatchStats::TOO_FEW_KEYPOINTS);
  EXPECT_TRUE(says(answer.text, {"only 0 keypoints", "the detector that made them found no more"}));
  messages.current.header.stamp = ros::Time(1.2);
  EXPECT_EQ(node.ask(messages.current).status, MatchStats::OK) << "compared with the one before";
}

TEST(KeypointsInput, WhatIsMalformedIsRefusedInASentence) {
  using Spoil = std::function<void(Keypoints&)>;
  const std::vector<std::pair<Spoil, std::string>> cases = {
      {[](Keypoints& m) { m.width = 0; }, "width or height is 0"},
      {[](Keypoints& m) { m.u[3] = std::nanf(""); }, "keypoint 3 lies outside the image"},
      {[](Keypoints& m) { m.descriptors.pop_back(); }, "descriptors has"},
      {[](Keypoints& m) { m.descriptor_size = 0; }, "descriptor_size is 0"},
      {[](Keypoints& m) { std::fill_n(m.descriptors.begin(), 4, uint8_t{0xff}); }, "descriptor 0 has a number"},
      {[](Keypoints& m) { m.u.assign(100001, 1); }, "send at most 100000"}};
  for (const auto& [spoil, sentence] : cases) {
    Messages messages;
    spoil(messages.current);
    KeypointsNode node;
    node.ask(messages.reference);
    const ProcessedFrame answer = node.ask(messages.current);
    EXPECT_EQ(answer.status, MatchStats::BAD_IMAGE) << sentence;
    EXPECT_TRUE(says(answer.text, {"image on /image not used: ", sentence}));
    messages.reference.header.stamp = ros::Time(1.2);
    messages.reference.u[0] = 20;  // or it would be a copy
    EXPECT_NE(node.ask(messages.reference).pair, nullptr) << "compared with the one before";
  }
}

TEST(KeypointsInput, AnotherDetectorIsANewBeginning) {
  Messages messages;
  KeypointsNode node;
  node.ask(messages.reference);
  messages.current.descriptor_type = Keypoints::DESCRIPTOR_BINARY;
  const ProcessedFrame answer = node.ask(messages.current);
  EXPECT_EQ(answer.status, MatchStats::FIRST_FRAME);
  EXPECT_TRUE(says(answer.text, {"the descriptors changed from 64 floats to 256 bytes"}));
}

}  // namespace
}  // namespace gms_ransac
