// MatchFilter with features of the caller's: pose of a drawn scene by float and by binary descriptors, and refusals.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "gms_ransac/match_filter.h"
#include "says.h"
#include "stages.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

constexpr int kPointCount = 500;

TwoViewScene drawnScene() {
  TwoViewSceneOptions options;
  options.matches = kPointCount;
  options.outlier_ratio = 0;
  options.noise_px = 0.2;
  return makeTwoViewScene(options);
}

/// Keypoints of the reference, or of the current image; those that noise moved out of the image are at its border.
template <typename Column>
Features featuresAt(const Column& x, const Column& y, const cv::Mat& descriptors) {
  Features features;
  features.image_size = {640, 480};
  for (size_t i = 0; i < kPointCount; ++i) {
    features.keypoints.emplace_back(std::clamp(x[i], 0.f, 639.f), std::clamp(y[i], 0.f, 479.f), 5.f);
  }
  features.descriptors.assign(descriptors);
  return features;
}

cv::Mat drawnDescriptors(int columns, int type) {
  cv::Mat rows(kPointCount, columns, type);
  if (type == CV_8U) cv::RNG(3).fill(rows, cv::RNG::UNIFORM, 0, 256);
  if (type == CV_32F) cv::RNG(3).fill(rows, cv::RNG::NORMAL, 0, 1);
  return rows;
}

/// As another image shows them.
cv::Mat seenAgain(const cv::Mat& rows) {
  cv::Mat noise(rows.size(), rows.type());
  if (rows.type() == CV_32F) {
    cv::RNG(4).fill(noise, cv::RNG::NORMAL, 0, 0.3);
    return rows + noise;
  }
  cv::RNG(4).fill(noise, cv::RNG::UNIFORM, 0, 2);
  return rows ^ noise;
}

TEST(GivenFeatures, ShowTheMotionOfADrawnScene) {
  const TwoViewScene scene = drawnScene();
  const PointPairs& pairs = scene.pairs;
  for (const auto& [columns, type] : {std::pair(64, CV_8U), std::pair(61, CV_8U), std::pair(32, CV_8U),
                                      std::pair(128, CV_32F), std::pair(256, CV_32F)}) {
    const cv::Mat rows = drawnDescriptors(columns, type);
    for (const char* method : {"lo_prosac", "cp_ransac", "lan"}) {
      SCOPED_TRACE(std::string(method) + ", " + std::to_string(columns) + (type == CV_8U ? " bytes" : " floats"));
      MatchFilterOptions options;
      options.method = method;
      MatchFilter filter(options);
      filter.setCamera(scene.camera);
      EXPECT_EQ(filter.process(featuresAt(pairs.x_reference, pairs.y_reference, rows)).status, Status::kFirstFrame);
      const MatchResult& result = filter.process(featuresAt(pairs.x_current, pairs.y_current, seenAgain(rows)));
      EXPECT_EQ(result.status, Status::kOk);
      EXPECT_GT(result.inliers, (method == std::string("lo_prosac") ? 0.9 : 0.5) * kPointCount);
      for (const Match& match : result.raw) EXPECT_EQ(match.reference, match.current);
      const PoseErrors errors = poseErrors(result.robust, scene.R, scene.t);
      EXPECT_LT(errors.rotation, 0.1);
      EXPECT_LT(errors.direction, 1);
    }
  }
}

TEST(GivenFeatures, OfOrbAnswerAsTheImagesDo) {
  cv::Mat noise(96, 228, CV_8UC1), texture;
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::resize(noise, texture, cv::Size(), 5, 5, cv::INTER_NEAREST);
  MatchFilterOptions options;
  options.align_points = false;  // features alone have no pixels
  MatchFilter of_images(options), of_features(options);
  for (const int shift : {0, 7, 16}) {
    const cv::Mat image = texture(cv::Rect(shift, 0, 640, 480)).clone();
    Frame frame;
    of_features.extract(image, frame);
    const MatchResult& expected = of_images.process(image);
    const MatchResult& result = of_features.process(frame.features);
    EXPECT_EQ(result.status, expected.status);
    EXPECT_EQ(stagesOf(result), stagesOf(expected));
    EXPECT_EQ(result.robust.judgement.probability, expected.robust.judgement.probability);
    EXPECT_EQ(result.raw.empty(), shift == 0);
  }
}

std::string refusalOf(const std::function<void(Features&)>& spoil) {
  const TwoViewScene scene = drawnScene();
  Features features = featuresAt(scene.pairs.x_reference, scene.pairs.y_reference, drawnDescriptors(64, CV_8U));
  spoil(features);
  MatchFilter filter;
  try {
    filter.process(features);
    return filter.process(features).status == Status::kUncalibrated ? "" : "compared with another status";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(GivenFeatures, MayHaveNegativeAngles) {
  // As another detector gives them, -180..180, of a camera that rolls by 30 degrees.
  const TwoViewScene scene = drawnScene();
  cv::Mat rows = drawnDescriptors(32, CV_8U);
  const auto withAngles = [&](bool negative, bool second) {
    const PointPairs& pairs = scene.pairs;
    Features features = second ? featuresAt(pairs.x_current, pairs.y_current, seenAgain(rows))
                               : featuresAt(pairs.x_reference, pairs.y_reference, rows);
    for (int i = 0; i < kPointCount; ++i) {
      const float angle = std::fmod(7.25f * static_cast<float>(i) + (second ? 30.f : 0.f), 360.f);
      features.keypoints[static_cast<size_t>(i)].angle = negative && angle > 180 ? angle - 360 : angle;
    }
    return features;
  };
  MatchResult results[2];
  for (const bool negative : {false, true}) {
    MatchFilter filter;
    filter.process(withAngles(negative, false));
    results[negative] = filter.process(withAngles(negative, true));
  }
  EXPECT_GT(results[0].inliers, 0);
  EXPECT_EQ(stagesOf(results[0]), stagesOf(results[1]));
  EXPECT_EQ(results[0].confidence, results[1].confidence);
  EXPECT_EQ(wrappedAngle(-90), 270);
  EXPECT_EQ(wrappedAngle(-1), -1) << "OpenCV's for an unknown one";

  MotionStatisticsOptions options;
  options.criterion = Criterion::kEvidence;
  MotionStatisticsFilter evidence(options);
  std::vector<float> log_odds[2];
  for (const bool negative : {false, true}) {
    const Features reference = withAngles(negative, false), current = withAngles(negative, true);
    std::vector<Match> matches;
    for (int i = 0; i < kPointCount; ++i) matches.push_back({i, i, 20, 90});
    MotionStatistics statistics;
    evidence.compute(reference, current, matches, statistics);
    log_odds[negative] = statistics.log_odds;
  }
  EXPECT_EQ(log_odds[0], log_odds[1]);
}

TEST(GivenFeatures, OfAnotherKindBeginANewSequence) {
  const TwoViewScene scene = drawnScene();
  const PointPairs& pairs = scene.pairs;
  const cv::Mat rows[] = {drawnDescriptors(64, CV_8U), drawnDescriptors(128, CV_32F)};
  MatchFilter filter;
  filter.setCamera(scene.camera);
  for (const cv::Mat& kind : {rows[0], rows[1], rows[0]}) {
    EXPECT_EQ(filter.process(featuresAt(pairs.x_reference, pairs.y_reference, kind)).status, Status::kFirstFrame);
    EXPECT_EQ(filter.reference().features.size(), 0);
    EXPECT_EQ(filter.process(featuresAt(pairs.x_current, pairs.y_current, seenAgain(kind))).status, Status::kOk);
    EXPECT_EQ(filter.reference().features.size(), kPointCount);
  }
}

TEST(GivenFeatures, AreRefusedWithWhatIsWrong) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(refusalOf([](Features&) {}), "");
  EXPECT_TRUE(says(refusalOf([](Features& f) { f.keypoints.pop_back(); }), {"499 keypoints and 500 descriptors"}));
  EXPECT_TRUE(says(refusalOf([](Features& f) { f.image_size = {}; }), {"image_size is not set"}));
  EXPECT_TRUE(says(refusalOf([](Features& f) { f.scale_factor = 1; }), {"scale_factor is not above 1"}));
  for (const float x : {kNan, -1.f, 640.f}) {
    EXPECT_TRUE(says(refusalOf([=](Features& f) { f.keypoints[4].pt.x = x; }), {"keypoint 4 lies outside the image"}));
  }
  for (const int octave : {-1, 16, 16712447}) {
    EXPECT_TRUE(says(refusalOf([=](Features& f) { f.keypoints[7].octave = octave; }),
                     {"keypoint 7 has octave " + std::to_string(octave), "cv::SIFT"}));
  }
  for (const float angle : {kNan, std::numeric_limits<float>::infinity(), 361.f}) {
    EXPECT_TRUE(says(refusalOf([=](Features& f) { f.keypoints[2].angle = angle; }), {"keypoint 2 has no angle"}));
  }
}

TEST(GivenFeatures, OfTwoKindsAreNotCompared) {
  const TwoViewScene scene = drawnScene();
  const Frame reference(featuresAt(scene.pairs.x_reference, scene.pairs.y_reference, drawnDescriptors(64, CV_8U)));
  const Frame current(featuresAt(scene.pairs.x_current, scene.pairs.y_current, drawnDescriptors(64, CV_32F)));
  MatchResult result;
  EXPECT_THROW(MatchFilter().filter(reference, current, result), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
