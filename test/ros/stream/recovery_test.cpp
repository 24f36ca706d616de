// Going on after a loss from an image before it: same tracks, true motion and covariance; and never from another place.
#include "stream/recovery.h"

#include <algorithm>
#include <optional>
#include <set>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "datasets/dataset.h"
#include "processor_stream.h"
#include "rendered_scene.h"
#include "says.h"
#include "scenes/scene.h"
#include "shared_data.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

ProcessorOptions recovering(int frames = 3) {
  ProcessorOptions options;
  options.recovery.frames = frames;
  return options;
}

/// A lens that is covered: nothing but noise.
cv::Mat covered(const cv::Size& size) {
  cv::Mat image(size, CV_8UC1);
  static cv::RNG random(1);
  random.fill(image, cv::RNG::NORMAL, 12, 1);
  return image;
}

/// A camera that is shaken: corners there are, but not those of the sharp image.
cv::Mat shaken(const cv::Mat& image) {
  cv::Mat blurred, grain(image.size(), CV_8SC1), result;
  cv::GaussianBlur(image, blurred, {}, 12);
  static cv::RNG random(1);
  random.fill(grain, cv::RNG::NORMAL, 0, 12);
  cv::add(blurred, grain, result, cv::noArray(), CV_8U);
  return result;
}

std::set<uint32_t> tracks(const ProcessedFrame& processed) {
  std::set<uint32_t> ids(processed.pair->track_ids.begin(), processed.pair->track_ids.end());
  ids.erase(0);
  return ids;
}

RelativePose relative(const Eigen::Isometry3d& reference, const Eigen::Isometry3d& current) {
  const Eigen::Isometry3d motion = reference.inverse() * current;
  RelativePose pose;
  pose.R = motion.linear();
  pose.t = motion.translation();
  return pose;
}

const Scene& room() {
  static const Scene scene([] {
    SceneOptions options;
    options.step = 0.01;
    return options;
  }());
  return scene;
}

/// The first images of the room.
ProcessedFrame begin(ImageStream& stream, int images, bool with_depth = false) {
  ProcessedFrame processed;
  for (int i = 0; i < images; ++i) {
    const RenderedFrame frame = room().render(i);
    processed = stream.process(frame.image, with_depth ? frame.depth : cv::Mat_<float>());
  }
  return processed;
}

void expectRecovered(const ProcessedFrame& processed) {
  ASSERT_TRUE(processed.recovered) << processed.text;
  EXPECT_EQ(processed.status, MatchStats::OK);
  EXPECT_EQ(processed.publishedStatus(), MatchStats::RECOVERED);
  EXPECT_EQ(processed.continuity, Continuity::kContinuous);
  EXPECT_TRUE(says(processed.text, {"goes on from the image of"}));
}

TEST(Recovery, GoesOnInTheRoomWhereItWasCovered) {
  for (const int images : {5, 20, 60}) {
    SCOPED_TRACE(images);
    constexpr int kBefore = 4;
    ImageStream stream(ScaleMode::kDepth, room().intrinsics(), recovering());
    const std::set<uint32_t> before = tracks(begin(stream, kBefore, true));
    for (int i = 0; i < images; ++i) {
      const ProcessedFrame dark = stream.process(covered(room().options().size));
      EXPECT_EQ(dark.status, MatchStats::TOO_FEW_KEYPOINTS) << dark.text;
      EXPECT_EQ(dark.continuity, Continuity::kContinuous);
    }
    const int now = kBefore + images;
    const RenderedFrame frame = room().render(now);
    const ProcessedFrame processed = stream.process(frame.image, frame.depth);
    expectRecovered(processed);
    EXPECT_TRUE(says(processed.text, {"and " + std::to_string(images) + " lost images"}));
    EXPECT_TRUE(processed.metric_scale);
    EXPECT_FALSE(processed.length_missing);
    const RelativePose truth = trueRelativePose(room(), kBefore - 1, now);
    EXPECT_LT((processed.pose.t - truth.t).norm(), 0.02 * truth.t.norm());
    EXPECT_LT(rotationError(processed.pose.R, truth.R), 0.025);
    EXPECT_LT(nees(processed.pose, truth), 3);
    RecordProperty("nees_" + std::to_string(images), std::to_string(nees(processed.pose, truth)));
    const std::set<uint32_t> after = tracks(processed);
    const auto same = std::count_if(after.begin(), after.end(), [&](uint32_t id) { return before.count(id) > 0; });
    EXPECT_GT(static_cast<double>(same), 0.7 * static_cast<double>(after.size())) << "the same tracks";
    const RenderedFrame next = room().render(now + 1);
    EXPECT_FALSE(stream.process(next.image, next.depth).recovered) << "once";
  }
}

TEST(Recovery, OffALossIsFinal) {
  ImageStream stream(ScaleMode::kUnit, room().intrinsics(), recovering(0));
  begin(stream, 2);
  stream.wait(2);
  const ProcessedFrame processed = stream.process(room().render(2).image);
  EXPECT_EQ(processed.status, MatchStats::TIME_RESET);
  EXPECT_EQ(processed.continuity, Continuity::kBroken);
}

TEST(Recovery, GoesOnAfterATimeWithoutImages) {
  ImageStream stream(ScaleMode::kUnit, room().intrinsics(), recovering());
  begin(stream, 2);
  stream.wait(2);
  const ProcessedFrame processed = stream.process(room().render(20).image);
  expectRecovered(processed);
  EXPECT_TRUE(processed.length_missing) << "a pair is not as long as all others";
  EXPECT_TRUE(says(processed.text, {"the length of the motion"}));

  stream.wait(11);
  const ProcessedFrame late = stream.process(room().render(21).image);
  EXPECT_EQ(late.status, MatchStats::TIME_RESET) << late.text;
  EXPECT_EQ(late.continuity, Continuity::kBroken);
}

TEST(Recovery, GoesOnAfterImagesThatShowSomethingElse) {
  ImageStream stream(ScaleMode::kUnit, room().intrinsics(), recovering());
  begin(stream, 3);
  for (int i = 3; i < 6; ++i) {
    const ProcessedFrame processed = stream.process(shaken(room().render(i).image));
    EXPECT_FALSE(processed.recovered) << processed.text;
    EXPECT_GT(processed.current->frame.features.size(), 100) << "there are corners";
  }
  expectRecovered(stream.process(room().render(6).image));
}

TEST(Recovery, IsRefusedInAnotherPlace) {
  SceneOptions elsewhere = room().options();
  elsewhere.seed = 7;
  const Scene other(elsewhere);
  ImageStream stream(ScaleMode::kUnit, room().intrinsics(), recovering());
  begin(stream, 3);
  stream.process(covered(elsewhere.size));
  EXPECT_FALSE(stream.process(other.render(0).image).poseValid());
  for (int i = 1; i < 7; ++i) {
    const ProcessedFrame processed = stream.process(other.render(i).image);
    EXPECT_FALSE(processed.recovered) << processed.text;
    EXPECT_TRUE(processed.poseValid()) << "pairs of the new place: " << processed.text;
  }
  stream.process(covered(elsewhere.size));
  expectRecovered(stream.process(other.render(9).image));
  stream.process(covered(elsewhere.size));
  EXPECT_FALSE(stream.process(room().render(4).image).recovered) << "the first place was given up";
}

TEST(Recovery, GoesOnAlongKitti06) {
  OPEN_OR_SKIP(dataset, "kitti_06");
  constexpr int kLast = 3;
  constexpr double kPeriod = 0.1;
  // After 20 the pose is right to half a degree, but LOW_PARALLAX. Its 49 inliers lie in fewer than 100 cells. Their
  // blocks give the rotation about the optical axis a deviation of 1.9 degrees where OK needs one.
  for (const int images : {5, 12, 45}) {
    SCOPED_TRACE(images);
    ImageStream stream(ScaleMode::kPropagate, *dataset->intrinsics(), recovering(), 1, kPeriod);
    double length = 0;
    for (int i = 0; i <= kLast; ++i) {
      const ProcessedFrame processed = stream.process(dataset->image(i));
      if (processed.poseValid()) length = processed.pose.t.norm();
    }
    for (int i = 0; i < images; ++i) stream.process(covered(dataset->image(0).size()));
    const int now = kLast + 1 + images;
    const ProcessedFrame processed = stream.process(dataset->image(now));
    if (images == 45) {
      EXPECT_FALSE(processed.recovered) << "after 55 m nothing is left of the view: " << processed.text;
      EXPECT_EQ(stream.process(dataset->image(now + 1)).status, MatchStats::OK);
      continue;
    }
    expectRecovered(processed);
    EXPECT_FALSE(processed.length_missing);
    const auto& frames = dataset->frames();
    const RelativePose truth = relative(*frames[kLast].pose, *frames[now].pose);
    EXPECT_LT(rotationError(processed.pose.R, truth.R), 0.7);
    EXPECT_LT(directionError(processed.pose.t, truth.t), 1);
    const double true_ratio = truth.t.norm() / relative(*frames[kLast - 1].pose, *frames[kLast].pose).t.norm();
    EXPECT_NEAR(processed.pose.t.norm() / length / true_ratio, 1, 0.1);
  }
}

}  // namespace
}  // namespace gms_ransac
