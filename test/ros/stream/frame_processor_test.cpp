// The choice of the reference, and the status and text of an image: resets, stamps, and depth with unusable images.
#include "stream/frame_processor.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <boost/make_shared.hpp>

#include "methods/method.h"
#include "output/message_conversion.h"
#include "processor_stream.h"
#include "quantiles.h"
#include "rendered_scene.h"
#include "says.h"
#include "scenes/scene.h"
#include "stream/status_text.h"
#include "two_view/sigma_by_octave.h"

namespace gms_ransac {
namespace {

constexpr int kWidth = 640, kHeight = 480;

sensor_msgs::ImageConstPtr image(double stamp, int shift = 0) {
  return imageMessage(measured(cornersMovedBy(shift), static_cast<uint64_t>(1000 * stamp)), stamp);
}

/// The same pixels with another stamp.
sensor_msgs::ImagePtr copyOf(const sensor_msgs::ImageConstPtr& original, double stamp) {
  auto copy = boost::make_shared<sensor_msgs::Image>(*original);
  copy->header.stamp = ros::Time(stamp);
  return copy;
}

sensor_msgs::ImagePtr badImage(double stamp) {
  auto message = boost::make_shared<sensor_msgs::Image>(*image(stamp));
  message->data.pop_back();
  return message;
}

sensor_msgs::ImageConstPtr depthOf(float metres) {
  return imageMessage(cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(metres)), 0);
}

/// A node, whose clock goes on independently of the stamps.
struct Node : Processor {
  explicit Node(ScaleMode scale = ScaleMode::kUnit) : Processor(calibrated(scale)) {}
  using Processor::ask;
  ProcessedFrame ask(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::ImageConstPtr& depth = nullptr) {
    ImageWithInfo input;
    input.image = image;
    input.depth = depth;
    input.received = ros::Time(clock += 0.1);
    return ask(input);
  }
  double clock = 1000;  // seconds
};

TEST(SigmaByOctave, IsThatOfTheResult) {
  RobustResult result;
  result.judgement.sigma_px = 0.7;
  result.judgement.noise_exponent = 0.5;
  const SigmaByOctave sigma(result.judgement, 1.2f);
  for (int octave = 0; octave < 16; ++octave)
    EXPECT_EQ(sigma[octave], static_cast<float>(result.judgement.sigma(octave, 1.2f)));
  EXPECT_EQ(SigmaByOctave(Judgement(), 1.2f)[3], 0);
}

TEST(FrameProcessor, AResetOutlivesImagesOfNoUse) {
  Node processor;
  processor.ask(image(1.0));
  EXPECT_NE(processor.ask(image(1.1, 5)).pair, nullptr);
  processor.requestReset();
  EXPECT_EQ(processor.ask(badImage(1.2)).status, MatchStats::BAD_IMAGE);
  EXPECT_EQ(processor.ask(image(1.1)).status, MatchStats::BAD_IMAGE) << "out of order";
  const ProcessedFrame processed = processor.ask(image(1.3, 10));
  EXPECT_EQ(processed.status, MatchStats::FIRST_FRAME);
  EXPECT_EQ(processed.continuity, Continuity::kRestarted);
  EXPECT_TRUE(says(processed.text, {"reset on request"}));
  EXPECT_EQ(processor.ask(image(1.4, 15)).continuity, Continuity::kContinuous) << "once";
}

TEST(FrameProcessor, AResetRestartsPairsToo) {
  Node processor;
  ImageWithInfo pair;
  pair.reference = image(1.0);
  pair.image = image(1.0, 5);
  EXPECT_EQ(processor.ask(pair).continuity, Continuity::kContinuous);
  processor.requestReset();
  const ProcessedFrame processed = processor.ask(pair);
  EXPECT_EQ(processed.continuity, Continuity::kRestarted);
  EXPECT_NE(processed.pair, nullptr) << "a pair is compared all the same";
  EXPECT_EQ(processor.ask(pair).continuity, Continuity::kContinuous);
}

TEST(FrameProcessor, OptionsAndResetsMayComeFromAnotherThread) {
  Node processor;
  std::atomic<bool> ended = false;
  std::thread service([&] {
    for (int i = 0; !ended; ++i) {
      ProcessorOptions options;
      options.core.extractor.features = 200 + 100 * (i % 3);
      processor.setOptions(options);
      processor.requestReset();
    }
  });
  for (int i = 0; i < 10; ++i) EXPECT_NE(processor.ask(image(1 + 0.1 * i, i)).status, MatchStats::BAD_IMAGE);
  ended = true;
  service.join();
}

TEST(FrameProcessor, SaysThatTheStampsAreFrozen) {
  Node processor;
  processor.ask(image(1.0));
  const ProcessedFrame frozen = processor.ask(image(1.0, 5));
  EXPECT_EQ(frozen.status, MatchStats::BAD_IMAGE);
  EXPECT_TRUE(says(frozen.text, {"the same as that of the image before it"}));
  EXPECT_NE(processor.ask(image(0.9, 5)).text.find("is 0.1 s older"), std::string::npos);
}

TEST(FrameProcessor, SaysWhichOfTwoImagesHasTooFewKeypoints) {
  const auto dark = [](double stamp) { return imageMessage(cv::Mat::zeros(kHeight, kWidth, CV_8UC1), stamp); };
  Node processor;
  processor.ask(dark(1.0));
  const ProcessedFrame bright = processor.ask(image(1.1));
  ASSERT_EQ(bright.status, MatchStats::TOO_FEW_KEYPOINTS) << bright.text;
  EXPECT_TRUE(says(bright.text, {"only 0 keypoints in the reference image"}));
  const ProcessedFrame covered = processor.ask(dark(1.2));
  EXPECT_TRUE(says(covered.text, {"only 0 keypoints (the reference has "}));
  EXPECT_EQ(processor.ask(image(1.3)).pair->reference->stamp(), 1.1) << "the last image that had keypoints";
}

TEST(FrameProcessor, SaysThatTooFewKeypointsAreAskedFor) {
  ProcessorOptions options;
  options.core.extractor.features = 7;
  ImageStream stream(ScaleMode::kUnit, {500, 500, 319.5, 239.5, "", {}}, options);
  stream.process(cornersMovedBy(0));
  const ProcessedFrame processed = stream.process(cornersMovedBy(5));
  ASSERT_EQ(processed.status, MatchStats::TOO_FEW_KEYPOINTS) << processed.text;
  EXPECT_TRUE(says(processed.text, {"~features is 7", "raise it"}));
  EXPECT_EQ(processed.text.find("dark"), std::string::npos) << processed.text;
}

TEST(FrameProcessor, SaysThatASlowCameraNeedsALongerGap) {
  Node processor;
  processor.ask(image(1.0));
  const ProcessedFrame processed = processor.ask(image(3.0, 5));
  ASSERT_EQ(processed.status, MatchStats::TIME_RESET);
  EXPECT_TRUE(says(processed.text, {"~max_frame_gap (1 s)", "raise it"}));
}

// Pixels that are equal bit for bit are no measurement.

TEST(Copies, AreMissedAndGiveNoVelocity) {
  Node processor;
  processor.ask(image(1.0));
  const sensor_msgs::ImageConstPtr last = image(1.1, 5);
  ASSERT_TRUE(processor.ask(last).poseValid());
  const ProcessedFrame copy = processor.ask(copyOf(last, 1.2));
  EXPECT_EQ(copy.status, MatchStats::BAD_IMAGE);
  EXPECT_TRUE(says(copy.text, {"a copy of the image before it, bit for bit"}));
  EXPECT_FALSE(copy.place);
  EXPECT_FALSE(copy.atRest());
  const ProcessedFrame next = processor.ask(image(1.3, 10));
  EXPECT_EQ(next.continuity, Continuity::kContinuous);
  EXPECT_EQ(next.pair->reference->stamp(), 1.1) << "what the reference shows was measured then";
  EXPECT_TRUE(next.velocity_known);
}

TEST(Copies, OfHalfOfTheRowsAreCopies) {
  Node processor;
  processor.ask(image(1.0));
  const sensor_msgs::ImageConstPtr last = image(1.1, 5);
  processor.ask(last);
  const sensor_msgs::ImagePtr torn = copyOf(image(1.2, 10), 1.2);
  std::copy(last->data.begin(), last->data.begin() + kHeight / 2 * kWidth, torn->data.begin());
  const ProcessedFrame processed = processor.ask(torn);
  EXPECT_EQ(processed.status, MatchStats::BAD_IMAGE);
  EXPECT_TRUE(says(processed.text, {"240 of its 480 rows are a copy"}));
  EXPECT_TRUE(processor.ask(image(1.3, 10)).poseValid()) << "the next one is whole";
}

/// A simulator without noise, whose camera stands for longer than ~max_frame_gap and moves on.
TEST(Copies, OfASimulatorAtRestDoNotEndItsStream) {
  Node processor;
  processor.ask(image(1.0));
  const sensor_msgs::ImageConstPtr last = image(1.1, 5);
  const Eigen::Isometry3d place = processor.ask(last).place->camera().pose;
  double stamp = 1.1;
  for (int i = 0; i < 50; ++i) EXPECT_EQ(processor.ask(copyOf(last, stamp += 0.1)).status, MatchStats::BAD_IMAGE);
  const ProcessedFrame moved = processor.ask(image(stamp += 0.1, 8));
  EXPECT_EQ(moved.continuity, Continuity::kContinuous) << moved.text;
  ASSERT_TRUE(moved.poseValid()) << moved.text;
  EXPECT_EQ(moved.pair->reference->stamp(), 1.1);
  EXPECT_FALSE(moved.velocity_known) << "an average over five seconds";
  ASSERT_TRUE(moved.place);
  EXPECT_EQ(moved.place->camera().twist_covariance(3, 3), kLargestVariance);
  EXPECT_LT((place.inverse() * moved.place->camera().pose).translation().norm(), 1.5);
  EXPECT_TRUE(processor.ask(image(stamp += 0.1, 13)).velocity_known) << "once";
}

TEST(Copies, ALoopMayBeginAsItEnded) {
  Node processor;
  const sensor_msgs::ImageConstPtr first = image(100);
  processor.ask(first);
  processor.ask(image(100.1, 5));
  processor.ask(copyOf(first, 100.2));
  EXPECT_EQ(processor.ask(copyOf(first, 10)).status, MatchStats::TIME_RESET);
  processor.requestReset();
  EXPECT_EQ(processor.ask(copyOf(first, 10.1)).status, MatchStats::FIRST_FRAME);
}

TEST(Copies, OfTheReferenceAreNoPair) {
  Node processor;
  ImageWithInfo pair;
  pair.reference = image(1.0);
  pair.image = copyOf(pair.reference, 1.0);
  EXPECT_TRUE(says(processor.ask(pair).text, {"a copy of the image before it"}));
}

/// A depth camera that froze while the colour camera goes on.
TEST(Copies, OfDepthImagesMeasureNoLength) {
  Node processor(ScaleMode::kDepth);
  const auto depth = [](double stamp) {
    cv::Mat metres(kHeight, kWidth, CV_32FC1);
    cv::RNG(static_cast<uint64_t>(1000 * stamp)).fill(metres, cv::RNG::NORMAL, 5, 0.01);
    return imageMessage(metres, stamp);
  };
  const sensor_msgs::ImageConstPtr frozen = depth(1.1);
  processor.ask(image(1.0), depth(1.0));
  EXPECT_TRUE(processor.ask(image(1.1, 5), frozen).metric_scale);
  EXPECT_TRUE(processor.ask(image(1.12, 6), frozen).metric_scale) << "one message for two images is no copy";
  for (int i = 2; i < 5; ++i) {
    const ProcessedFrame copy = processor.ask(image(1 + 0.1 * i, 5 * i), copyOf(frozen, 1 + 0.1 * i));
    ASSERT_TRUE(copy.poseValid()) << copy.text;
    EXPECT_EQ(copy.metric_scale, i == 2) << "the reference has depth of its own: " << copy.text;
    EXPECT_TRUE(copy.current->stereo.depth.empty());
    const std::string which = "the depth image: it is a copy of the image before it, bit for bit";
    EXPECT_TRUE(says(copy.text, {which}));
    EXPECT_EQ(copy.text.find(which), copy.text.rfind(which)) << copy.text;
  }
  EXPECT_TRUE(processor.ask(image(1.5, 25), depth(1.5)).metric_scale);
  // A simulator without noise, at rest.
  const ProcessedFrame rest = processor.ask(copyOf(image(1.5, 25), 1.6), copyOf(depth(1.5), 1.6));
  EXPECT_EQ(rest.status, MatchStats::BAD_IMAGE);
  EXPECT_EQ(rest.text.find("the depth image"), std::string::npos) << rest.text;
}

// Stamps and frames that change without a word.

TEST(FrameProcessor, NoVelocitySpansAClockThatWasSetBack) {
  Node processor;
  processor.ask(image(1.0));
  processor.ask(image(1.1, 5));
  processor.ask(image(1.2, 10));
  EXPECT_EQ(processor.ask(image(1.0, 15)).status, MatchStats::BAD_IMAGE) << "it may have been overtaken";
  const ProcessedFrame stepped = processor.ask(image(1.1, 20));
  EXPECT_EQ(stepped.status, MatchStats::TIME_RESET) << stepped.text;
  EXPECT_EQ(stepped.continuity, Continuity::kBroken) << "the place stays";
  EXPECT_TRUE(says(stepped.text, {"the stamps went back", "the clock that sets them"}));
  EXPECT_FALSE(stepped.place);
  const ProcessedFrame next = processor.ask(image(1.2, 25));
  EXPECT_EQ(next.pair->reference->stamp(), 1.1);
  EXPECT_TRUE(next.velocity_known);
  EXPECT_FALSE(next.place_restarted);
  // By less than two images: it cannot be told from one that was overtaken.
  EXPECT_EQ(processor.ask(image(1.15, 30)).status, MatchStats::BAD_IMAGE);
  const ProcessedFrame unsure = processor.ask(image(1.25, 35));
  ASSERT_TRUE(unsure.poseValid()) << unsure.text;
  EXPECT_FALSE(unsure.velocity_known);
  EXPECT_EQ(unsure.place->camera().twist_covariance(3, 3), kLargestVariance);
}

TEST(FrameProcessor, AnotherFrameIsAnotherCamera) {
  Node processor;
  const auto by = [&](const std::string& camera, double stamp, int shift) {
    const sensor_msgs::ImagePtr message = copyOf(image(stamp, shift), stamp);
    message->header.frame_id = camera;
    return processor.ask(message);
  };
  by("left", 1.0, 0);
  ASSERT_TRUE(by("left", 1.1, 5).place);
  for (int i = 2; i < 8; ++i) {
    const ProcessedFrame processed = by(i % 2 == 0 ? "right" : "left", 1 + 0.1 * i, 5 * i);
    EXPECT_EQ(processed.status, MatchStats::FIRST_FRAME) << processed.text;
    EXPECT_EQ(processed.continuity, Continuity::kBroken);
    EXPECT_FALSE(processed.place) << "a sum of both would be no place of either";
    EXPECT_TRUE(
        says(processed.text, {i % 2 == 0 ? "from 'left' to 'right'" : "from 'right' to 'left'", "two cameras"}));
  }
  const ProcessedFrame alone = by("left", 1.8, 40);
  ASSERT_TRUE(alone.poseValid()) << alone.text;
  EXPECT_TRUE(alone.place_restarted);
  ASSERT_TRUE(alone.place);
  EXPECT_LT(alone.place->camera().pose.translation().norm(), 1.5) << "from where it was alone";
}

/// ~max_milliseconds: 2000 features are reached after some images that ask for more and more.
TEST(FrameProcessor, AChangeKeepsTheTimeBudgetThatItDoesNotTouch) {
  Node processor;
  ProcessorOptions options;
  options.core.max_milliseconds = 10000;
  processor.setOptions(options);
  double stamp = 1;
  const auto asked = [&] {
    stamp += 0.1;
    const ProcessedFrame processed = processor.ask(image(stamp, static_cast<int>(stamp * 50) % 40));
    return processed.current->frame.features_asked;
  };
  for (int i = 0; i < 20; ++i) asked();
  ASSERT_EQ(asked(), 2000);
  options.max_frame_gap = 2;  // of the stream
  processor.setOptions(options);
  EXPECT_EQ(asked(), 2000);
  options.core.robust.max_direction_sigma = 5;  // of the core, but of no cost
  processor.setOptions(options);
  EXPECT_EQ(asked(), 2000);
  options.core.extractor.pyramid_levels = 4;
  processor.setOptions(options);
  EXPECT_LT(asked(), 1000) << "what an image costs is to be learnt anew";
}

TEST(FrameProcessor, OfACameraAtRestTheTranslationIsNotKnown) {
  Node processor;
  processor.ask(image(1.0));
  const ProcessedFrame processed = processor.ask(image(1.1));
  EXPECT_EQ(processed.status, MatchStats::LOW_PARALLAX) << processed.text;
  EXPECT_EQ(processed.pose.t, Eigen::Vector3d::Zero());
  EXPECT_GT(processed.pose.covariance(0, 0), 100);
  EXPECT_TRUE(says(processed.text, {"the camera is at rest"}));
}

TEST(FrameProcessor, WhereTheCameraStandsStillItsVelocityIsZero) {
  Node processor;
  processor.ask(image(1.0));
  ASSERT_FALSE(processor.ask(image(1.1, 5)).atRest());
  const ProcessedFrame processed = processor.ask(image(1.2, 5));
  ASSERT_TRUE(processed.atRest()) << processed.text;
  OdometryEstimate estimate = processed.place->camera();
  forgetLength(processed.atRest(), estimate);
  EXPECT_EQ(Eigen::Vector3d(estimate.twist.head<3>()), Eigen::Vector3d::Zero());
  EXPECT_GT(estimate.twist_covariance(0, 0), 1e-6);
  EXPECT_LT(estimate.twist_covariance(0, 0), 0.01) << "in metres, whatever ~scale is";
}

TEST(FrameProcessor, WhereDepthGivesTheTranslationTheTextSaysSo) {
  Node processor(ScaleMode::kDepth);
  processor.ask(image(1.0), depthOf(5));
  const ProcessedFrame processed = processor.ask(image(1.1), depthOf(5));
  ASSERT_EQ(processed.status, MatchStats::OK) << processed.text;
  EXPECT_TRUE(processed.metric_scale);
  EXPECT_EQ(processed.text.find("rotation only"), std::string::npos) << processed.text;
  EXPECT_TRUE(says(processed.text, {"agree on one motion"}));
}

TEST(FrameProcessor, APairWithoutDepthHasNoLength) {
  Node processor(ScaleMode::kDepth);
  processor.ask(image(1.0));
  const ProcessedFrame processed = processor.ask(image(1.1));
  EXPECT_FALSE(processed.metric_scale);
  EXPECT_TRUE(processed.poseValid()) << processed.text;
  EXPECT_TRUE(says(processed.text, {"no length: no depth image"}));
}

TEST(FrameProcessor, NothingIsFoundInAnImageThatIsNotUsed) {
  Node processor;
  for (int i = 0; i < 4; ++i) ASSERT_GT(processor.ask(image(1 + 0.1 * i, 5 * i)).current->frame.features.size(), 100);
  const ProcessedFrame refused = processor.ask(badImage(1.5));
  EXPECT_EQ(refused.status, MatchStats::BAD_IMAGE);
  EXPECT_EQ(refused.current->frame.features.size(), 0) << "of an image before it";
  EXPECT_EQ(refused.current->frame.features_asked, 0);
  EXPECT_TRUE(refused.current->image.camera) << "that of the image before";
}

/// Bytes that the process has asked for and not given back; zero where the allocator does not say (sanitizers' do not).
size_t heldBytes() {
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  const struct mallinfo2 held = mallinfo2();
#else
  const struct mallinfo held = mallinfo();
#endif
  return static_cast<size_t>(held.uordblks) + static_cast<size_t>(held.hblkhd);
}

/// Every method with every model and extractor, and with them what each has of its own.
void reconfigureThroughAll(Node& processor, double& stamp) {
  const std::vector<sensor_msgs::ImageConstPtr> views = {image(0), image(0, 5), image(0, 10)};
  for (const MethodEntry& method : methods()) {
    for (const ModelType model : {ModelType::kFundamental, ModelType::kHomography, ModelType::kEssential}) {
      ProcessorOptions options;
      options.core.method = method.name;
      options.core.robust.model = model;
      options.core.robust.max_iterations = 50;
      options.core.extractor.extractor = model == ModelType::kHomography ? "opencv" : "simd_orb";
      options.core.extractor.features = model == ModelType::kEssential ? 300 : 200;
      processor.setOptions(options);
      for (const sensor_msgs::ImageConstPtr& view : views) {
        const auto next = boost::make_shared<sensor_msgs::Image>(*view);
        next->header.stamp = ros::Time(stamp += 0.1);
        processor.ask(next);
      }
    }
  }
}

TEST(FrameProcessor, ReconfigurationsLeaveNothingBehind) {
  if (heldBytes() == 0) GTEST_SKIP() << "the allocator does not say what is held";
  Node processor;
  double stamp = 1;
  for (int warm = 0; warm < 2; ++warm) reconfigureThroughAll(processor, stamp);
  const size_t before = heldBytes();
  for (int again = 0; again < 3; ++again) reconfigureThroughAll(processor, stamp);
  // Containers of another size may keep some bytes; a filter that is not freed would be some hundred kilobytes.
  EXPECT_LT(heldBytes(), before + 50000);
}

TEST(FrameProcessor, AReplacedPipelineGoesWithItsFrames) {
  if (heldBytes() == 0) GTEST_SKIP() << "the allocator does not say what is held";
  Node processor;
  double stamp = 1;
  const auto runWith = [&](int features) {
    ProcessorOptions options;
    options.core.extractor.features = features;
    options.core.extractor.fast_threshold = 0;
    processor.setOptions(options);
    for (const int shift : {0, 5, 10}) processor.ask(image(stamp += 0.1, shift));
  };
  runWith(300);
  const size_t of_few = heldBytes();
  runWith(20000);
  const size_t held = heldBytes();
  runWith(300);
  const size_t given_back = held - heldBytes();  // all but what results and tracks keep room for
  EXPECT_GT(given_back, (held - of_few) * 2 / 3);
  EXPECT_GT(given_back, 1000000u);
}

TEST(Calibration, WithoutOneThereAreCorrespondencesAlone) {
  Processor processor{Parameters()};
  ImageWithInfo input;
  input.camera_info = boost::make_shared<sensor_msgs::CameraInfo>();
  input.image = imageMessage(renderedFrame(0).image, 100);
  processor.ask(input);
  input.image = imageMessage(renderedFrame(2).image, 100.1);
  const ProcessedFrame processed = processor.ask(input);
  EXPECT_EQ(processed.status, MatchStats::UNCALIBRATED);
  EXPECT_TRUE(says(processed.text, {"no pose: the camera_info on /camera_info is not calibrated"}));
  Correspondences message;
  toMessage(processed, false, message);
  EXPECT_FALSE(message.pose_valid);
  EXPECT_EQ(message.K, (boost::array<double, 9>{}));
  ASSERT_GT(message.probability.size(), 100u);
  EXPECT_GT(quantilesOf(message.probability).median, 0.5) << "weighed by the fundamental matrix";
}

TEST(MotionUnknown, HasAPoseOnlyForThoseWhoAskForIt) {
  ProcessorOptions options;
  options.core.robust.min_pose_probability = options.core.robust.min_rotation_probability = 1;
  for (const bool asked : {false, true}) {
    Parameters parameters = calibrated();
    parameters.publish_uncertain = asked;
    Processor processor(parameters, options);
    ImageWithInfo input;
    ProcessedFrame processed;
    for (int i = 0; i < 2; ++i) {
      input.image = imageMessage(renderedFrame(2 * i).image, 100 + 0.1 * i);
      processed = processor.ask(input);
    }
    EXPECT_EQ(processed.status, MatchStats::MOTION_UNKNOWN) << processed.text;
    EXPECT_FALSE(processed.poseValid() || processed.place) << "the odometry has none";
    Correspondences message;
    toMessage(processed, false, message);
    EXPECT_EQ(message.pose_valid, asked);
    EXPECT_EQ(message.current_in_reference.covariance[0] > 0, asked);
  }
}

/// Published K is that of the received image, with which camera_info's coefficients undistort: of a lens with a sphere
/// that is not the pinhole camera's, whose focal length is smaller by 1 + xi.
TEST(Calibration, OfALensWithASphereIsPublishedAsItCame) {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = kWidth;
  info->height = kHeight;
  info->distortion_model = "omnidirectional";
  info->D = {1.5, -0.1, 0.05, 0, 0};
  info->K = {700, 0, 320, 0, 710, 240, 0, 0, 1};
  Processor processor{Parameters()};
  ImageWithInfo input;
  input.camera_info = info;
  ProcessedFrame processed;
  for (int i = 0; i < 2; ++i) {
    input.image = imageMessage(renderedFrame(i).image, 100 + 0.1 * i);
    processed = processor.ask(input);
  }
  ASSERT_NE(processed.pair, nullptr);
  Correspondences message;
  toMessage(processed, false, message);
  Keypoints keypoints;
  toMessage(processed, keypoints);
  EXPECT_EQ(message.pixel_space, Correspondences::PIXELS_RAW);
  EXPECT_EQ(message.K, info->K);
  EXPECT_EQ(keypoints.K, info->K);
}

TEST(Status, NamesTheValuesOfA16BitImageWithoutKeypoints) {
  Processor processor{calibrated()};
  ImageWithInfo input;
  std::string text;
  for (int i = 0; i < 2; ++i) {
    cv::Mat plain(480, 640, CV_16UC1, cv::Scalar(18000));
    plain.at<uint16_t>(100, 100) = 65535;
    std_msgs::Header header;
    header.stamp = ros::Time(100 + 0.1 * i);
    input.image = cv_bridge::CvImage(header, "mono16", plain).toImageMsg();
    text = processor.ask(input).text;
  }
  EXPECT_TRUE(
      says(text, {"the image is dark, blurred or plain", "(its grey levels are those of the values 18000 to 18015)"}));
}

TEST(Calibration, DoubtsAreInTheStatusText) {
  Parameters parameters;
  parameters.camera = {500, 500, 600, 240, "", {}};
  Processor processor{parameters};
  ImageWithInfo input;
  for (int i = 0; i < 2; ++i) {
    input.image = imageMessage(renderedFrame(i).image, 100 + 0.1 * i);
    const ProcessedFrame processed = processor.ask(input);
    EXPECT_TRUE(says(processed.doubt, {"at 93.8 % of the width"}));
    EXPECT_TRUE(says(processed.text, {"; doubtful: " + processed.doubt}));
  }
}

/// A depth image in millimetres that says 32FC1.
TEST(Calibration, DepthThatCannotBeInMetresIsDoubted) {
  ImageStream stream(ScaleMode::kDepth, renderedScene().intrinsics(), {});
  cv::Mat millimetres = 1000 * renderedFrame(0).depth;
  EXPECT_TRUE(says(stream.process(renderedFrame(0).image, millimetres).text, {"doubtful: the median depth is"}));
  EXPECT_EQ(stream.process(renderedFrame(1).image, renderedFrame(1).depth).doubt, "");
}

/// A depth camera that adds 0.02 / m to every inverse depth.
TEST(Calibration, WhatItLeavesOfADepthCameraIsLearnt) {
  constexpr float kWrong = 0.02F;
  ImageStream stream(ScaleMode::kDepth, renderedScene().intrinsics(), {});
  ProcessedFrame processed;
  for (int i = 0; i < 24; ++i) {
    const cv::Mat wrong = 1 / (1 / renderedFrame(i).depth + kWrong);
    processed = stream.process(renderedFrame(i).image, wrong);
  }
  ASSERT_TRUE(processed.offset);
  EXPECT_TRUE(processed.offset->isOff());
  MatchStats message;
  toMessage(processed, {}, message);
  EXPECT_LT(message.inverse_depth_error_sigma, 0.003);
  EXPECT_NEAR(message.inverse_depth_error, -kWrong, 3 * message.inverse_depth_error_sigma);
}

/// The room through a lens of that focal length, with its camera_info.
ImageWithInfo roomThrough(double focal_length, const std::vector<double>& distortion, int frame) {
  SceneOptions options;
  options.focal_length = focal_length;
  options.distortion = distortion;
  const Scene scene(options);
  const CameraIntrinsics& k = scene.intrinsics();
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = kWidth;
  info->height = kHeight;
  info->distortion_model = "plumb_bob";
  info->D = distortion;
  info->K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
  ImageWithInfo input;
  input.image = imageMessage(scene.render(frame).image, 100 + 0.1 * frame);
  input.camera_info = info;
  input.received = input.image->header.stamp;
  return input;
}

TEST(Calibration, OfEachImageIsItsOwn) {
  const std::vector<double> wide = {-0.2, 0.05, 0, 0, 0}, narrow = {-0.1, 0.02, 0, 0, 0};
  const RelativePose truth = trueRelativePose(Scene(SceneOptions()), 0, 2);
  Processor processor{Parameters()};
  processor.ask(roomThrough(500, wide, 0));
  const ProcessedFrame processed = processor.ask(roomThrough(560, narrow, 2));
  ASSERT_EQ(processed.status, MatchStats::OK) << processed.text;
  EXPECT_LT(Eigen::AngleAxisd(processed.pose.R * truth.R.transpose()).angle(), 0.1 * M_PI / 180);
  EXPECT_GT(processed.pose.t.normalized().dot(truth.t.normalized()), std::cos(2 * M_PI / 180));
  EXPECT_LT(processed.pair->result.robust.judgement.camera_misfit, 1);
}

}  // namespace
}  // namespace gms_ransac
