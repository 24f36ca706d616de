// What is compared with what, and what is said of an image: resets, stamps and depth that come with images of no use.
#include "frame_processor.h"

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

constexpr int kWidth = 640, kHeight = 480;

/// Corners everywhere, moved by some pixels.
sensor_msgs::ImagePtr image(double stamp, int shift = 0) {
  cv::Mat noise(kHeight / 5, kWidth / 5 + 20, CV_8UC1), texture;
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::resize(noise, texture, cv::Size(), 5, 5, cv::INTER_NEAREST);
  const cv::Mat view = texture(cv::Rect(shift, 0, kWidth, kHeight)).clone();
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->header.stamp = ros::Time(stamp);
  message->header.frame_id = "camera";
  message->encoding = "mono8";
  message->width = message->step = kWidth;
  message->height = kHeight;
  message->data.assign(view.data, view.data + view.total());
  return message;
}

sensor_msgs::ImagePtr badImage(double stamp) {
  const sensor_msgs::ImagePtr message = image(stamp);
  message->data.pop_back();
  return message;
}

sensor_msgs::ImagePtr depthOf(double metres) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->encoding = "32FC1";
  message->width = kWidth;
  message->height = kHeight;
  message->step = kWidth * sizeof(float);
  const std::vector<float> depth(kWidth * kHeight, static_cast<float>(metres));
  const auto* bytes = reinterpret_cast<const uint8_t*>(depth.data());
  message->data.assign(bytes, bytes + depth.size() * sizeof(float));
  return message;
}

class Processor {
 public:
  explicit Processor(ScaleMode scale = ScaleMode::kUnit) : processor_(parameters(scale), "/image", "/camera_info") {
    processor_.setOptions(ProcessorOptions());
  }

  ProcessedFrame ask(const ImageWithInfo& input) { return processor_.process(processor_.prepare(input)); }
  ProcessedFrame ask(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::ImageConstPtr& depth = nullptr) {
    ImageWithInfo input;
    input.image = image;
    input.depth = depth;
    input.received = ros::Time(clock_ += 0.1);
    return ask(input);
  }
  FrameProcessor* operator->() { return &processor_; }

 private:
  static Parameters parameters(ScaleMode scale) {
    Parameters parameters;
    parameters.scale = scale;
    parameters.camera = {500, 500, 319.5, 239.5, "", {}};
    return parameters;
  }
  FrameProcessor processor_;
  double clock_ = 1000;  // the node's, seconds
};

TEST(StatusName, IsThatOfTheMessage) {
  EXPECT_EQ(statusName(MatchStats::OK), "OK");
  EXPECT_EQ(statusName(MatchStats::UNCALIBRATED), "UNCALIBRATED");
  EXPECT_EQ(statusName(MatchStats::TIME_RESET), "TIME_RESET");
  EXPECT_EQ(statusName(MatchStats::BAD_IMAGE), "BAD_IMAGE");
}

TEST(FrameProcessor, AResetOutlivesImagesOfNoUse) {
  Processor processor;
  processor.ask(image(1.0));
  EXPECT_NE(processor.ask(image(1.1, 5)).result, nullptr);
  processor->requestReset();
  EXPECT_EQ(processor.ask(badImage(1.2)).status, MatchStats::BAD_IMAGE);
  EXPECT_EQ(processor.ask(image(1.1)).status, MatchStats::BAD_IMAGE) << "out of order";
  const ProcessedFrame processed = processor.ask(image(1.3, 10));
  EXPECT_EQ(processed.status, MatchStats::FIRST_FRAME);
  EXPECT_EQ(processed.continuity, Continuity::kRestarted);
  EXPECT_EQ(processor.ask(image(1.4, 15)).continuity, Continuity::kContinuous) << "once";
}

TEST(FrameProcessor, AResetRestartsPairsToo) {
  Processor processor;
  ImageWithInfo pair;
  pair.reference = image(1.0);
  pair.image = image(1.0, 5);
  EXPECT_EQ(processor.ask(pair).continuity, Continuity::kContinuous);
  processor->requestReset();
  const ProcessedFrame processed = processor.ask(pair);
  EXPECT_EQ(processed.continuity, Continuity::kRestarted);
  EXPECT_NE(processed.result, nullptr) << "a pair is compared all the same";
  EXPECT_EQ(processor.ask(pair).continuity, Continuity::kContinuous);
}

TEST(FrameProcessor, SaysThatTheStampsAreFrozen) {
  Processor processor;
  processor.ask(image(1.0));
  const ProcessedFrame frozen = processor.ask(image(1.0, 5));
  EXPECT_EQ(frozen.status, MatchStats::BAD_IMAGE);
  EXPECT_NE(frozen.text.find("the same as that of the image before it"), std::string::npos) << frozen.text;
  EXPECT_NE(processor.ask(image(0.9, 5)).text.find("is 0.1 s before"), std::string::npos);
}

TEST(FrameProcessor, WhereDepthGivesTheTranslationTheTextSaysSo) {
  Processor processor(ScaleMode::kDepth);
  processor.ask(image(1.0), depthOf(5));
  const ProcessedFrame processed = processor.ask(image(1.1), depthOf(5));
  ASSERT_EQ(processed.status, MatchStats::OK) << processed.text;
  EXPECT_TRUE(processed.metric_scale);
  EXPECT_EQ(processed.text.find("cannot be observed"), std::string::npos) << processed.text;
  EXPECT_NE(processed.text.find("agree on one motion"), std::string::npos) << processed.text;
}

TEST(FrameProcessor, APairWithoutDepthHasNoLength) {
  Processor processor(ScaleMode::kDepth);
  processor.ask(image(1.0));
  const ProcessedFrame processed = processor.ask(image(1.1));
  EXPECT_FALSE(processed.metric_scale);
  EXPECT_TRUE(processed.poseValid()) << processed.text;
  EXPECT_NE(processed.text.find("no length: no depth image"), std::string::npos) << processed.text;
}

}  // namespace
}  // namespace gms_ransac
