// The choice among optima, each scene with one that a search may end in.
#include "methods/optima.h"

#include <gtest/gtest.h>

#include "ransac/proposals.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

/// A drawn pair, its columns and the true motion.
struct Pair {
  TwoViewScene scene;
  TwoViewPoints points;
  const ResidualKernels& kernels = residualKernels(detectSimdLevel());
  TwoViewPose truth;

  explicit Pair(const TwoViewSceneOptions& options) : scene(makeTwoViewScene(options)) {
    points.set(scene.pairs, scene.camera, ModelType::kEssential, 1, 0.5);
    truth = {scene.R, scene.t.normalized()};
  }
  TwoViewPose optimumNear(TwoViewPose pose) const {
    PoseModel(kernels, points.view()).refine(kRobustLoss, 50, pose, 1e-6f);
    return pose;
  }
  double error(const TwoViewPose& pose) const { return directionError(pose.t, truth.t); }
};

TEST(Optima, LeaveTheWrongMotionOfAPlane) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    TwoViewSceneOptions options;
    options.seed = seed;
    options.shape = SceneShape::kPlane;
    options.off_plane = 0.15;
    const Pair pair(options);
    std::vector<float> storage;
    const auto other = findOtherPlaneMotion({pair.kernels, pair.points.view()}, pair.optimumNear(pair.truth), storage);
    ASSERT_TRUE(other);
    const TwoViewPose wrong = pair.optimumNear(*other);
    ASSERT_GT(pair.error(wrong), 5) << seed;
    Optima optima(pair.kernels);
    EXPECT_LT(pair.error(optima.choose(pair.points, wrong, {})), 2) << seed;
    // The judgement compares both the optima that it left and the one that it chose with the pose.
    EXPECT_GE(optima.alternatives.size(), 2u);
  }
}

TEST(Optima, StayWithTheRightOne) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    TwoViewSceneOptions options;
    options.seed = seed;
    const Pair pair(options);
    const TwoViewPose right = pair.optimumNear(pair.truth);
    std::vector<TwoViewPose> starts;
    findMotionStarts(pair.kernels, pair.points.view(), starts);
    Optima optima(pair.kernels);
    EXPECT_LT(pair.error(optima.choose(pair.points, right, starts)), 0.5) << seed;
  }
}

TEST(Optima, PreferAStartThatExplainsMore) {
  TwoViewSceneOptions options;
  const Pair pair(options);
  TwoViewPose wrong = pair.truth;
  wrong.t = Eigen::Vector3d(wrong.t.y(), wrong.t.z(), wrong.t.x()).normalized();
  wrong = pair.optimumNear(wrong);
  Optima optima(pair.kernels);
  EXPECT_LT(pair.error(optima.choose(pair.points, wrong, {pair.truth})), 0.5);
}

}  // namespace
}  // namespace gms_ransac
