// A stream that the test holds in its hand: what one step answers, what it makes of the stream, and what a loss costs.
#include "stream/step.h"

#include <limits>
#include <memory>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "datasets/dataset.h"
#include "match_filter_hooks.h"
#include "processor_stream.h"
#include "scale/depth_pose.h"
#include "scenes/scene.h"
#include "stream/odometry.h"
#include "stream/status_text.h"

namespace gms_ransac {
namespace {

const Scene& steppedRoom() {
  static const Scene scene{SceneOptions()};
  return scene;
}

class StepTest : public testing::Test {
 protected:
  explicit StepTest(int kept = 0)
      : pipeline_(calibrated(ScaleMode::kUnit, steppedRoom().intrinsics()), keeping(kept)) {}

  static ProcessorOptions keeping(int frames) {
    ProcessorOptions options;
    options.recovery.frames = frames;
    return options;
  }
  std::shared_ptr<PreparedFrame> prepared(const cv::Mat& grey) {
    auto frame = std::make_shared<PreparedFrame>();
    frame->image.grey = grey;
    frame->image.header.stamp = ros::Time(stamp_ += 0.2);
    frame->image.stamp_verdict = StampVerdict::kInOrder;
    auto camera = std::make_shared<CameraModel>();
    camera->camera = Camera(steppedRoom().intrinsics(), grey.size());
    frame->image.camera = camera;
    pipeline_.filter.extract(grey, frame->frame, cv::Mat(), stamp_);
    return frame;
  }
  ProcessedFrame ask(const cv::Mat& grey) { return step(pipeline_, stream_, recovery_, pairs_, prepared(grey)); }

  Pipeline pipeline_;
  Stream stream_;
  Recovery recovery_;
  PairPool pairs_;
  double stamp_ = 100;
};

TEST_F(StepTest, ACopyOfTheStreamAnswersTheSame) {
  ask(steppedRoom().render(0).image);
  ask(steppedRoom().render(1).image);
  Stream copy = stream_;
  const std::shared_ptr<PreparedFrame> next = prepared(steppedRoom().render(2).image);
  const ProcessedFrame one = step(pipeline_, stream_, recovery_, pairs_, next);
  const RelativePose pose = one.pose;
  const std::vector<uint32_t> ids = one.pair->track_ids;
  const Eigen::Isometry3d place = one.place->camera().pose;
  ask(steppedRoom().render(3).image);
  const ProcessedFrame other = step(pipeline_, copy, recovery_, pairs_, next);
  EXPECT_EQ(other.status, MatchStats::OK) << words(other, pipeline_.options);
  EXPECT_EQ(other.pose.t, pose.t);
  EXPECT_EQ(other.pair->track_ids, ids);
  EXPECT_EQ(other.place->camera().pose.matrix(), place.matrix());
}

TEST_F(StepTest, AnotherImageSizeLeavesThePlace) {
  for (int i = 0; i < 3; ++i) ask(steppedRoom().render(i).image);
  const OdometryEstimate before = stream_.place.camera();
  ASSERT_GT(before.pose.translation().norm(), 1);
  cv::Mat small;
  cv::resize(steppedRoom().render(3).image, small, {320, 240}, 0, 0, cv::INTER_AREA);
  const ProcessedFrame answer = ask(small);
  EXPECT_EQ(answer.status, MatchStats::FIRST_FRAME);
  EXPECT_EQ(answer.continuity, Continuity::kBroken);
  EXPECT_FALSE(answer.place) << "it moved meanwhile";
  EXPECT_FALSE(answer.place_restarted);
  EXPECT_EQ(stream_.place.camera().pose.matrix(), before.pose.matrix());
  EXPECT_GT(stream_.place.camera().pose_covariance(0, 0), before.pose_covariance(0, 0) + 0.5);
}

TEST_F(StepTest, AnotherKindOfDescriptorsLeavesThePlace) {
  for (int i = 0; i < 3; ++i) ask(steppedRoom().render(i).image);
  const Eigen::Isometry3d before = stream_.place.camera().pose;
  ASSERT_GT(before.translation().norm(), 1);
  const std::shared_ptr<PreparedFrame> other = prepared(steppedRoom().render(3).image);
  const int keypoints = other->frame.features.size();
  other->frame.features.descriptors.assign(cv::Mat::ones(keypoints, 64, CV_32F));
  const ProcessedFrame answer = step(pipeline_, stream_, recovery_, pairs_, other);
  EXPECT_EQ(answer.status, MatchStats::FIRST_FRAME);
  EXPECT_EQ(answer.continuity, Continuity::kBroken);
  EXPECT_FALSE(answer.place) << "it moved meanwhile";
  EXPECT_FALSE(answer.place_restarted);
  EXPECT_EQ(stream_.place.camera().pose.matrix(), before.matrix());
}

TEST_F(StepTest, AfterAFailedWayBackTheAnswerHasItsColumns) {
  Pipeline pipeline(calibrated(ScaleMode::kUnit, steppedRoom().intrinsics()), keeping(3));
  SceneOptions elsewhere;
  elsewhere.seed = 7;
  const Scene other(elsewhere);
  for (int i = 0; i < 3; ++i) step(pipeline, stream_, recovery_, pairs_, prepared(steppedRoom().render(i).image));
  step(pipeline, stream_, recovery_, pairs_, prepared(cv::Mat::zeros(steppedRoom().options().size, CV_8UC1)));
  int with_matches = 0;
  for (int i = 0; i < 5; ++i) {
    const ProcessedFrame answer = step(pipeline, stream_, recovery_, pairs_, prepared(other.render(i).image));
    if (answer.pair == nullptr) continue;
    with_matches += answer.pair->result.size() > 0 && !answer.poseValid();
    EXPECT_EQ(answer.pair->track_ids.size(), answer.pair->result.matches.size());
    EXPECT_EQ(answer.pair->track_lengths.size(), answer.pair->result.matches.size());
  }
  EXPECT_GT(with_matches, 0);
}

/// A key frame that is not a number stands for every cause of one.
TEST_F(StepTest, AMotionSinceTheKeyFrameThatIsUnfitIsNotUsed) {
  Pipeline pipeline(calibrated(ScaleMode::kDepth, steppedRoom().intrinsics()), ProcessorOptions());
  const auto next = [&](int i) {
    const RenderedFrame rendered = steppedRoom().render(i);
    const std::shared_ptr<PreparedFrame> frame = prepared(rendered.image);
    frame->stereo.depth = keypointDepth(frame->frame.features, rendered.depth);
    return step(pipeline, stream_, recovery_, pairs_, frame);
  };
  for (int i = 0; i < 3; ++i) next(i);
  ASSERT_FALSE(stream_.key.points.empty());
  stream_.key.reference.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  for (int i = 3; i < 6; ++i) {
    const ProcessedFrame answer = next(i);
    EXPECT_TRUE(stream_.place.camera().pose.matrix().allFinite()) << i << " " << words(answer, pipeline.options);
    EXPECT_LT(stream_.place.camera().pose_covariance(0, 0), kLargestVariance) << i;
  }
}

TEST_F(StepTest, TheReferenceShowsItsPixelsWithTheAnswer) {
  Recovery keeps;
  Pipeline pipeline(calibrated(ScaleMode::kUnit, steppedRoom().intrinsics()), keeping(3));
  for (int i = 0; i < 3; ++i) {
    const ProcessedFrame answer = step(pipeline, stream_, keeps, pairs_, prepared(steppedRoom().render(i).image));
    if (i > 0) {
      EXPECT_FALSE(answer.pair->reference->image.grey.empty());
    }
  }
  EXPECT_EQ(keeps.kept().size(), 2u);
  EXPECT_TRUE(keeps.kept().back().reference->image.grey.empty()) << "it is kept without them";
}

TEST_F(StepTest, ALossCostsFourComparisonsAtMostAndSaysSo) {
  SceneOptions elsewhere;
  elsewhere.seed = 7;
  const Scene other(elsewhere);
  for (const int kept : {1, 3, 6}) {
    Pipeline pipeline(calibrated(ScaleMode::kUnit, steppedRoom().intrinsics()), keeping(kept));
    Recovery recovery;
    Stream stream;
    for (int i = 0; i < 8; ++i) step(pipeline, stream, recovery, pairs_, prepared(steppedRoom().render(i).image));
    EXPECT_EQ(recovery.kept().size(), static_cast<size_t>(kept));
    step(pipeline, stream, recovery, pairs_, prepared(cv::Mat::zeros(steppedRoom().options().size, CV_8UC1)));
    step(pipeline, stream, recovery, pairs_, prepared(other.render(0).image));
    // A clock that counts how often it is read: as often in each comparison that goes to its end.
    double now = 0;
    MatchFilterHooks::setClock(pipeline.filter, [&] { return ++now; });
    const ProcessedFrame answer = step(pipeline, stream, recovery, pairs_, prepared(other.render(1).image));
    EXPECT_FALSE(answer.recovered);
    EXPECT_EQ(answer.times.match, 1 + std::min(kept, 3));
  }
}

// ~input: pair.

class PairsTest : public StepTest {
 protected:
  PairsTest()
      : of_pairs_(
            [] {
              Parameters parameters = calibrated(ScaleMode::kUnit, steppedRoom().intrinsics());
              parameters.input = InputKind::kPair;
              return parameters;
            }(),
            ProcessorOptions()) {}

  /// The pair of images with these numbers.
  ProcessedFrame ask(int reference, int current) {
    const auto image = [&](int i) {
      stamp_ = 100 + 0.1 * i;
      return prepared(steppedRoom().render(i).image);
    };
    const std::shared_ptr<PreparedFrame> before = image(reference), frame = image(current);
    frame->pair_reference = before;
    return step(of_pairs_, stream_, recovery_, pairs_, frame);
  }
  double angle() const { return Eigen::AngleAxisd(stream_.place.camera().pose.linear()).angle(); }

  Pipeline of_pairs_;
};

TEST_F(PairsTest, CountNoMotionTwice) {
  constexpr int kApart = 3;
  double chained = 0;
  for (int i = 0; i < 2 * kApart + 1; ++i) {
    const ProcessedFrame answer = ask(i, i + kApart);
    ASSERT_TRUE(answer.poseValid()) << words(answer, of_pairs_.options);
    EXPECT_EQ(answer.place.has_value(), i % kApart == 0) << i << ": overlaps the pair before";
    if (answer.place.has_value()) chained += Eigen::AngleAxisd(answer.pose.R).angle();
  }
  EXPECT_LT(angle(), 1.05 * chained);
  EXPECT_GT(angle(), 0.5 * chained);
  const double before = stream_.place.camera().pose_covariance(0, 0);
  EXPECT_TRUE(ask(12, 13).place);
  EXPECT_GT(stream_.place.camera().pose_covariance(0, 0), before + 0.5) << "the motion between was missed";
  const ProcessedFrame back = ask(0, 1);
  EXPECT_TRUE(back.place_restarted) << "the pairs began anew";
}

}  // namespace
}  // namespace gms_ransac
