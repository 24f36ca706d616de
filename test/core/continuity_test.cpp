// Answers compared with the past of their stream, on drawn scenes with a body that moves by itself.
#include "past/continuity.h"
#include "judgement/probability.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "two_view/pose_model.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

constexpr int kScenes = 40;

/// A slow camera before which a body crosses; or, without one, a camera that moves away sideways. `speed`: metres from
/// image to image.
TwoViewScene makeView(uint64_t seed, double body_share, double speed = 0.6) {
  TwoViewSceneOptions options;
  options.seed = seed;
  options.outlier_ratio = 0.1;
  options.rotation = {0, 0, 0};
  options.nearest = 20;
  options.farthest = 60;
  options.translation = {0, 0, body_share > 0 ? -0.15 : 0};
  if (body_share > 0) {
    options.bodies = {{body_share, {speed, 0, 0}}};
  } else {
    options.translation = {-1, 0, 0};
  }
  return makeTwoViewScene(options);
}

struct Answer {
  RobustResult robust;
  Past past;
  bool ok() const { return robust.judgement.translation_observable; }
};

/// `tracks`: share of the static matches that continue static tracks; the stream went forwards for `steady` pairs, and
/// the last one showed `guess`.
Answer answer(const TwoViewScene& scene, double tracks, int steady, const RobustOptions& robust = RobustOptions(),
              const Eigen::Vector3d& guess = {0, 0, 1}) {
  MatchResult result;
  result.pairs = scene.pairs;
  const int count = result.keypoints_reference = result.keypoints_current = scene.pairs.size();
  Answer answer;
  answer.past.steady = steady;
  answer.past.direction = {0, 0, 1};
  answer.past.guess = guess;
  answer.past.reference_static.resize(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    result.matches.push_back({i, i, 0, 0});
    const bool first = i < tracks * count;
    answer.past.reference_static[static_cast<size_t>(i)] = first && scene.body[static_cast<size_t>(i)] == 0;
  }
  const auto method = makeEstimator("lo_prosac", robust);
  method->estimate(scene.pairs, scene.camera, result.robust);
  if (tracks >= 0) {
    Continuity().check(*method, scene.camera, result, answer.past);
    decide(robust, result.robust.judgement);
    continuePast(result, answer.past);
  }
  answer.robust = result.robust;
  return answer;
}

constexpr double kWithoutPast = -1;

TEST(Continuity, ABodyThatTakesOverTheViewIsNotFollowed) {
  int alone = 0, followed = 0, published = 0;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    const TwoViewScene scene = makeView(seed, 0.6);
    const Eigen::Vector3d forwards(0, 0, 1);
    const auto follows = [&](const Answer& a) {
      return a.ok() && directionError(a.robust.judgement.pose.t, forwards) > 30;
    };
    alone += follows(answer(scene, kWithoutPast, 0));
    const Answer held = answer(scene, 1, 4);
    followed += follows(held);
    published += held.ok();
    EXPECT_TRUE(held.ok() || held.past.steady == 3);
  }
  EXPECT_GE(alone, kScenes / 4) << "two views alone often take the body for the world";
  EXPECT_EQ(followed, 0);
  EXPECT_GT(published, 0) << "the static motion where it is determined";
}

TEST(Continuity, StaticTracksAnswerWhereAllMatchesTogetherDoNot) {
  int unknown = 0, published = 0, wrong = 0;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    const TwoViewScene scene = makeView(seed, 0.4, 1);
    const Answer alone = answer(scene, kWithoutPast, 0);
    if (alone.ok() || !alone.robust.judgement.pose_found) continue;
    ++unknown;
    const Answer held = answer(scene, 1, 4);
    published += held.ok();
    wrong += held.ok() && directionError(held.robust.judgement.pose.t, {0, 0, 1}) > 30;
    EXPECT_FALSE(answer(scene, 1, 0).ok()) << "no stream to continue";
  }
  EXPECT_GE(unknown, 5);
  EXPECT_EQ(published, unknown);
  EXPECT_EQ(wrong, 0);
}

TEST(Continuity, ACameraMayTurnAwayAtOnce) {
  int ok = 0, held_ok = 0;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    const TwoViewScene scene = makeView(seed, 0);
    ok += answer(scene, kWithoutPast, 0).ok();
    const Answer held = answer(scene, 1, 4);
    held_ok += held.ok();
    EXPECT_EQ(held.past.steady, held.ok() ? 4 : 3);
  }
  EXPECT_GE(ok, kScenes - 2);
  EXPECT_GE(held_ok, ok - 1);
}

TEST(Continuity, ADirectionThatThePairBeforeDidNotShowMustBeKnownTwiceAsWell) {
  const TwoViewScene scene = makeView(1, 0);
  const Answer alone = answer(scene, kWithoutPast, 0);
  ASSERT_TRUE(alone.ok());
  const Eigen::Matrix3d of_direction = alone.robust.judgement.pose.covariance.topLeftCorner<3, 3>();
  const double sigma = std::sqrt(of_direction.eigenvalues().real().maxCoeff()) * 180 / M_PI;
  RobustOptions options;
  options.max_direction_sigma = 1.5 * sigma;
  const Answer refused = answer(scene, 1, 0, options, Eigen::Vector3d::Zero());
  EXPECT_FALSE(refused.ok());
  EXPECT_TRUE(refused.robust.judgement.pose_found);
  EXPECT_EQ(refused.robust.judgement.doubt, DirectionDoubt::kUnconfirmed);
  EXPECT_TRUE(answer(scene, 1, 0, options, alone.robust.judgement.pose.t).ok());
  EXPECT_TRUE(answer(scene, 1, 0, options, refused.past.current_guess).ok())
      << "what is refused confirms the next pair";
  options.max_direction_sigma = 2.5 * sigma;
  EXPECT_TRUE(answer(scene, 1, 0, options, Eigen::Vector3d::Zero()).ok());
}

TEST(Continuity, DirectionsRotateWithTheCameraAndStayWithAReferenceThatIsHeld) {
  TwoViewSceneOptions options;
  options.outlier_ratio = 0;
  options.translation.setZero();
  options.rotation = {0, 0.4, 0};
  const TwoViewScene scene = makeTwoViewScene(options);
  Answer rotated = answer(scene, 1, 4);
  ASSERT_FALSE(rotated.ok());
  const Eigen::Vector3d before(0, 0, 1);
  EXPECT_EQ(rotated.past.direction, before) << "the next image may be compared with the same reference";
  EXPECT_LT(directionError(rotated.past.current_direction, scene.R * before), 2);
}

TEST(Continuity, AnglesWithoutStampsAreThoseOfThirtyImagesASecond) {
  MatchResult result;
  result.robust.judgement.pose_found = true;
  result.robust.judgement.pose.R = rotationFromVector({0, 0.1, 0});
  const auto velocity = [&result] {
    Past past;
    continuePast(result, past);
    past.shutter.advance();
    return past.shutter.velocityBefore()->value.y();
  };
  EXPECT_NEAR(velocity(), 3, 1e-9);
  result.pairs.seconds = 0.5;
  EXPECT_NEAR(velocity(), 0.2, 1e-9);
}

Features drawnImage(uint64_t seed) {
  Features features;
  features.image_size = {640, 480};
  features.keypoints.resize(100);
  cv::Mat rows(100, 32, CV_8U);
  cv::RNG(seed).fill(rows, cv::RNG::UNIFORM, 0, 256);
  features.descriptors.assign(rows);
  return features;
}

TEST(Past, TheImagesSayWhetherItsReferenceMovesOn) {
  const Features first = drawnImage(1), second = drawnImage(2), third = drawnImage(3), other = drawnImage(4);
  Past past;
  past.startPair(first, second);
  past.reference_static = {1};
  const auto answer = [&past](double z) {  // as a comparison leaves it
    past.current_static = {0, 1};
    past.current_direction = {0, 0, z};
    past.steady = 2;
  };
  answer(1);
  past.startPair(first, third);  // the reference is held
  EXPECT_TRUE(past.isStatic(0));
  EXPECT_EQ(past.direction.z(), 0);
  answer(2);
  Features moved = third;  // a copy whose keypoints are where another calibration shows them
  moved.keypoints[3].pt.x += 5;
  past.startPair(moved, first);
  EXPECT_FALSE(past.isStatic(0));
  EXPECT_TRUE(past.isStatic(1));
  EXPECT_EQ(past.direction.z(), 2);
  answer(3);
  past.startPair(other, third);  // nothing is known of this one
  EXPECT_FALSE(past.isStatic(1));
  EXPECT_EQ(past.direction.z(), 0);
  EXPECT_EQ(past.steady, 0);
}

TEST(Continuity, OnlyWhatTheMotionExplainsIsStaticForTheNextPair) {
  const TwoViewScene scene = makeView(1, 0.3);
  const Answer held = answer(scene, 1, 4);
  ASSERT_TRUE(held.ok());
  int wrong = 0;
  for (size_t i = 0; i < scene.body.size(); ++i) wrong += held.past.current_static[i] != (scene.body[i] == 0);
  EXPECT_LT(wrong, 0.1 * static_cast<double>(scene.body.size()));
}

}  // namespace
}  // namespace gms_ransac
