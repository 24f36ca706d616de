// The whole pipeline, from image to relative pose, on the rendered scenes: the paper's method and the default one, with
// default options.
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "gms_ransac/match_filter.h"
#include "percentile.h"
#include "rendered_scene.h"
#include "run/truth.h"
#include "stages.h"

namespace gms_ransac {
namespace {

/// Limits of the medians over 20 pairs, degrees: 1.5 times the measured values. In the room `lo_prosac` pays for its
/// prior of the parallax with hundredths of a degree of rotation.
struct Limits {
  const char *method, *scene;
  double rotation, direction;
};

class PipelineOnScene : public ::testing::TestWithParam<Limits> {};

TEST_P(PipelineOnScene, MedianPoseErrorIsSmall) {
  const Scene& scene = renderedScene(GetParam().scene);
  MatchFilterOptions filter_options;
  filter_options.method = GetParam().method;
  MatchFilter filter(filter_options);
  filter.setCamera(cameraOf(scene));
  std::vector<double> rotation, direction;
  for (int i = 0; i < 240; i += 12) {
    filter.reset();
    filter.process(renderedFrame(i, GetParam().scene).image);
    const MatchResult& result = filter.process(renderedFrame(i + 1, GetParam().scene).image);
    ASSERT_TRUE(result.robust.judgement.pose_found) << "pair " << i << ": " << toString(result.status);
    const Eigen::Isometry3d truth = scene.pose(i).inverse() * scene.pose(i + 1);
    const PoseError error = poseError(truth, result.robust.judgement.pose.R, result.robust.judgement.pose.t);
    rotation.push_back(error.rotation);
    direction.push_back(error.direction);
  }
  EXPECT_LT(median(rotation), GetParam().rotation);
  EXPECT_LT(median(direction), GetParam().direction);
}

TEST(PipelineOnStreams, ThatShareAFilterAnswersAsOnEachAlone) {
  constexpr int kFirst[] = {0, 100}, kImages = 4;
  const auto image = [&](int stream, int i) { return renderedFrame(kFirst[stream] + i, "room").image; };
  MatchFilter shared;
  shared.setCamera(cameraOf(renderedScene("room")));
  Frame frames[2][kImages];
  Past pasts[2];
  for (int i = 0; i < kImages; ++i) {
    for (int stream : {0, 1}) shared.extract(image(stream, i), frames[stream][i]);
  }
  MatchFilter alone[2];
  for (MatchFilter& filter : alone) filter.setCamera(shared.camera());
  for (int stream : {0, 1}) alone[stream].process(image(stream, 0));
  MatchResult result;
  for (int i = 1; i < kImages; ++i) {
    for (int stream : {0, 1}) {
      shared.filter(frames[stream][i - 1], frames[stream][i], result, nullptr, &pasts[stream]);
      const MatchResult& expected = alone[stream].process(image(stream, i));
      EXPECT_EQ(stagesOf(result), stagesOf(expected));
      EXPECT_EQ(result.robust.judgement.probability, expected.robust.judgement.probability);
      EXPECT_EQ(result.robust.judgement.pose.t, expected.robust.judgement.pose.t);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(MethodsAndScenes, PipelineOnScene,
                         ::testing::Values(Limits{"lo_prosac", "room", 0.04, 0.4},
                                           Limits{"lo_prosac", "street", 0.012, 0.25},
                                           Limits{"cp_ransac", "room", 0.018, 0.45},
                                           Limits{"cp_ransac", "street", 0.012, 0.3}),
                         [](const auto& info) { return std::string(info.param.method) + "_" + info.param.scene; });

}  // namespace
}  // namespace gms_ransac
