// Something that is fixed to the camera before a view that moves, on drawn scenes; and what only looks like it.
#include "past/fixed_to_camera.h"
#include "judgement/probability.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "gms_ransac/status_text.h"
#include "says.h"
#include "support/random.h"
#include "two_view/pose_model.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

constexpr int kViews = 12;
const Eigen::Vector3d kRotation(0.01, -0.06, 0.02);  // 3.7 degrees, 30 pixels

/// The scene with a window of that share of the image; `everywhere`: its matches lie all over the image.
TwoViewScene makeWindow(uint64_t seed, double share, const Eigen::Vector3d& camera_rotation,
                        const Eigen::Vector3d& body_translation, bool everywhere = false) {
  TwoViewSceneOptions options;
  options.seed = seed;
  options.outlier_ratio = 0.05;
  options.rotation = camera_rotation;
  options.translation.setZero();
  options.bodies = {{share, body_translation, {0, 0, 0}, 3, 4.5, everywhere}};
  return makeTwoViewScene(options);
}

/// A camera that only rotates; the matches in the window stay in place.
TwoViewScene makeOverlay(uint64_t seed, double share, bool everywhere = false) {
  TwoViewScene scene = makeWindow(seed, share, kRotation, {0, 0, 0}, everywhere);
  Random random(seed);
  for (size_t i = 0; i < scene.body.size(); ++i) {
    if (scene.body[i] != 1) continue;
    scene.pairs.x_current[i] = scene.pairs.x_reference[i] + static_cast<float>(0.1 * gaussian(random));
    scene.pairs.y_current[i] = scene.pairs.y_reference[i] + static_cast<float>(0.1 * gaussian(random));
  }
  return scene;
}

struct Settled {
  RobustResult alone;  ///< by the method
  RobustResult robust;
  Status status;
  std::string text;
};

/// `by_tracks`: all but the window is known to be static.
Settled settle(const TwoViewScene& scene, bool by_tracks = false) {
  MatchResult result;
  result.pairs = scene.pairs;
  Past past;
  for (int i = 0; i < scene.pairs.size(); ++i) {
    result.matches.push_back({i, i, 0, 0});
    past.reference_static.push_back(scene.body[static_cast<size_t>(i)] == 0);
  }
  const RobustOptions options;
  const auto method = makeEstimator("lo_prosac", options);
  method->estimate(result.pairs, scene.camera, result.robust);
  Settled settled;
  settled.alone = result.robust;
  FixedToCamera().resolve(*method, scene.camera, result, by_tracks ? &past : nullptr);
  decide(options, result.robust.judgement);
  settled.robust = result.robust;
  settled.status = statusOf(result.robust, scene.camera);
  StatusCircumstances of_node;
  of_node.option_prefix = "~";
  settled.text = explain(settled.status, result, {}, of_node);
  return settled;
}

double errorOf(const RobustResult& robust, const Eigen::Vector3d& rotation) {
  return rotationError(robust.judgement.pose.R.transpose(), rotationFromVector(rotation));
}

double rotationSigma(const RobustResult& robust) {
  return std::sqrt(robust.judgement.pose.covariance.bottomRightCorner<3, 3>().trace()) * 180 / M_PI;
}

TEST(FixedToCamera, TheRotationIsThatOfTheViewBehindItOrOpen) {
  int found = 0;
  for (uint64_t seed = 1; seed <= kViews; ++seed) {
    for (const bool everywhere : {false, true}) {
      const TwoViewScene scene = makeOverlay(seed, 0.35, everywhere);
      const Settled settled = settle(scene);
      EXPECT_NE(settled.status, Status::kOk);
      EXPECT_LT(errorOf(settled.robust, kRotation), std::max(0.5, 3 * rotationSigma(settled.robust)));
      if (settled.robust.judgement.evidence[Evidence::kFixedToCamera] > 0) continue;
      ++found;
      EXPECT_LT(errorOf(settled.robust, kRotation), 0.5);
      for (size_t i = 0; i < scene.body.size(); ++i) {
        ASSERT_TRUE(scene.body[i] != 1 ||
                    (settled.robust.inlier[i] == 0 && settled.robust.judgement.probability[i] == 0));
      }
    }
  }
  EXPECT_GT(found, kViews);
}

TEST(FixedToCamera, WhatFillsMostOfTheViewLosesToStaticTracks) {
  for (uint64_t seed = 1; seed <= kViews; ++seed) {
    const Settled settled = settle(makeOverlay(seed, 0.7), true);
    EXPECT_LT(errorOf(settled.robust, kRotation), 0.5);
    EXPECT_EQ(settled.status, Status::kLowParallax);
  }
}

TEST(FixedToCamera, WithoutAMajorityBothMotionsArePossible) {
  int wrong_alone = 0, open = 0;
  for (uint64_t seed = 1; seed <= kViews; ++seed) {
    const Settled settled = settle(makeOverlay(seed, 0.6));
    wrong_alone += errorOf(settled.alone, kRotation) > 1;
    if (!(settled.robust.judgement.evidence[Evidence::kFixedToCamera] > 0.1)) continue;
    ++open;
    if (settled.robust.judgement.doubt == DirectionDoubt::kFixedToCamera) {
      EXPECT_TRUE(
          says(settled.text, {"a part of the view stays in place", "a ~mask over what is fixed to the camera"}));
    }
    EXPECT_FALSE(settled.robust.judgement.translation_observable);
    EXPECT_LT(errorOf(settled.robust, kRotation), 4 * rotationSigma(settled.robust));
    EXPECT_LT(errorOf(settled.robust, {0, 0, 0}), 3 * rotationSigma(settled.robust));
  }
  EXPECT_GT(wrong_alone, 0);
  EXPECT_GT(open, 0);
}

TEST(FixedToCamera, ABodyBeforeACameraAtRestIsNoView) {
  for (uint64_t seed = 1; seed <= kViews; ++seed) {
    for (const bool by_tracks : {false, true}) {
      const Settled settled = settle(makeWindow(seed, by_tracks ? 0.65 : 0.25, {0, 0, 0}, {0.3, 0, 0}), by_tracks);
      EXPECT_TRUE(by_tracks || settled.status == Status::kLowParallax);
      if (errorOf(settled.alone, {0, 0, 0}) < 0.2) {
        EXPECT_LT(errorOf(settled.robust, {0, 0, 0}), 0.2);
      }
      EXPECT_LT(rotationSigma(settled.robust), 1);
    }
  }
}

TEST(FixedToCamera, FarPointsAheadOfADriveStay) {
  for (uint64_t seed = 1; seed <= kViews; ++seed) {
    TwoViewSceneOptions options;
    options.seed = seed;
    options.rotation.setZero();
    options.translation = {0, 0, -0.8};
    options.background = 0.4;
    const Settled settled = settle(makeTwoViewScene(options));
    ASSERT_TRUE(settled.alone.judgement.translation_observable);
    EXPECT_EQ(settled.robust.judgement.pose.R, settled.alone.judgement.pose.R);
    EXPECT_EQ(settled.robust.judgement.pose.t, settled.alone.judgement.pose.t);
    EXPECT_EQ(settled.robust.judgement.pose.covariance, settled.alone.judgement.pose.covariance);
  }
}

}  // namespace
}  // namespace gms_ransac
