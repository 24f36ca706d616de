// The learned mask of a node's stream: when it restricts the extraction, and how long it is kept.
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "processor_stream.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

const cv::Size kVga(640, 480);

/// Image `n` of a camera that sways about its centre, with something fixed to it in the lower quarter of its view.
sensor_msgs::ImageConstPtr image(int n, const std::string& frame_id = "camera") {
  static const cv::Mat room = [] {
    cv::Mat noise(200, 260, CV_8UC1), texture;
    cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::resize(noise, texture, cv::Size(), 5, 5, cv::INTER_NEAREST);
    return texture;
  }();
  const Eigen::Matrix3d K = (Eigen::Matrix3d() << 500, 0, 319.5, 0, 500, 239.5, 0, 0, 1).finished();
  Eigen::Matrix3d centred = K;
  centred.topRightCorner<2, 1>() << 0.5 * room.cols, 0.5 * room.rows;
  const double phase = 0.5 * n;
  cv::Mat to_room, seen;
  cv::eigen2cv(
      Eigen::Matrix3d(centred * rotationFromVector({0.04 * std::sin(phase), 0.05 * std::cos(phase), 0}) * K.inverse()),
      to_room);
  cv::warpPerspective(room, seen, to_room, kVga, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  cornersMovedBy(0).rowRange(360, 480).copyTo(seen.rowRange(360, 480));
  const sensor_msgs::ImageConstPtr message = imageMessage(measured(seen, static_cast<uint64_t>(n)), 100 + 0.04 * n);
  if (frame_id == message->header.frame_id) return message;
  auto other = boost::make_shared<sensor_msgs::Image>(*message);
  other->header.frame_id = frame_id;
  return other;
}

ImageWithInfo input(const sensor_msgs::ImageConstPtr& image) {
  ImageWithInfo input;
  input.image = image;
  input.received = image->header.stamp;
  return input;
}

/// The mask as it was when the image was compared; the pair itself does not change it.
LearnedMask maskOf(const ProcessedFrame& answer) { return answer.pair ? answer.pair->result.mask : LearnedMask(); }

std::vector<cv::Point2f> pointsOf(const Features& features) {
  std::vector<cv::Point2f> points;
  cv::KeyPoint::convert(features.keypoints, points);
  return points;
}

TEST(LearnedMask, RestrictsTheExtractionOfTheThirdImageAfterIt) {
  constexpr int kImages = 16, kAhead = 2;
  Processor serial(calibrated()), ahead(calibrated());
  std::vector<LearnedMask> masks;  // before each pair
  std::vector<std::vector<cv::Point2f>> points;
  for (int n = 0; n < kImages; ++n) {
    const ProcessedFrame answer = serial.ask(input(image(n)));
    masks.push_back(maskOf(answer));
    points.push_back(pointsOf(answer.current->frame.features));
  }
  ASSERT_FALSE(masks[kImages - 3].empty());
  MatchFilter filter{MatchFilterOptions()};
  for (int n = 2; n < kImages; ++n) {
    Frame expected;
    const LearnedMask& mask = masks[static_cast<size_t>(n - 2)];  // after the pair of n - 3
    filter.extract(cv_bridge::toCvShare(image(n))->image, expected, mask.forExtraction(cv::Mat(), kVga));
    EXPECT_EQ(points[static_cast<size_t>(n)], pointsOf(expected.features)) << n;
  }
  // However far the first thread is ahead.
  std::vector<Prepared> waiting;
  for (int n = 0; n < kImages + kAhead; ++n) {
    if (n < kImages) waiting.push_back(ahead.prepare(ahead.receive(input(image(n)))));
    if (n < kAhead) continue;
    const auto k = static_cast<size_t>(n - kAhead);
    EXPECT_EQ(maskOf(ahead.process(waiting[k])), masks[k]) << k;
    EXPECT_EQ(pointsOf(waiting[k].frame->frame.features), points[k]) << k;
  }
}

TEST(LearnedMask, OutlivesALossAndNoResetAndNoOtherCamera) {
  const auto begin = [](Processor& processor) {
    for (int n = 0; n < 11; ++n) processor.ask(input(image(n)));
    ASSERT_FALSE(maskOf(processor.ask(input(image(11)))).empty());
  };
  Processor lost(calibrated()), reset(calibrated()), other(calibrated());
  begin(lost);
  EXPECT_EQ(lost.ask(input(image(200))).status, MatchStats::TIME_RESET);
  EXPECT_FALSE(maskOf(lost.ask(input(image(201)))).empty());
  begin(reset);
  reset.requestReset();
  for (int n = 12; n < 14; ++n) EXPECT_TRUE(maskOf(reset.ask(input(image(n)))).empty());
  begin(other);
  for (int n = 12; n < 14; ++n) EXPECT_TRUE(maskOf(other.ask(input(image(n, "other")))).empty());
}

TEST(LearnedMask, RestrictsNoImageAfterStampsThatRestart) {
  Processor processor(calibrated());
  for (int n = 0; n < 12; ++n) processor.ask(input(image(n)));
  MatchFilter filter{MatchFilterOptions()};
  for (int n = -200; n < -197; ++n) {  // a bag that is played again
    const ProcessedFrame answer = processor.ask(input(image(n)));
    EXPECT_EQ(answer.status == MatchStats::TIME_RESET, n == -200);
    Frame whole;
    filter.extract(cv_bridge::toCvShare(image(n))->image, whole);
    EXPECT_EQ(pointsOf(answer.current->frame.features), pointsOf(whole.features)) << n;
  }
}

}  // namespace
}  // namespace gms_ransac
