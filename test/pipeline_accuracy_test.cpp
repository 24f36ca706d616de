// The whole line, image to relative pose, with its default options on the rendered scene.
#include <algorithm>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "gms_ransac/match_filter.h"
#include "scenes/synthetic_pair.h"

namespace gms_ransac {
namespace {

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

class PipelineOnScene : public ::testing::TestWithParam<const char*> {};

TEST_P(PipelineOnScene, MedianPoseErrorIsSmall) {
  SceneOptions options;
  options.scene = GetParam();
  const Scene scene(options);
  MatchFilter filter;
  filter.setCamera(Camera(scene.intrinsics(), options.size));
  std::vector<double> rotation, direction;
  for (int i = 0; i < 240; i += 12) {
    filter.reset();
    filter.process(scene.render(i).image);
    const MatchResult& result = filter.process(scene.render(i + 1).image);
    ASSERT_TRUE(result.robust.pose_found) << "pair " << i << ": " << toString(result.status);
    const RelativePose truth = trueRelativePose(scene, i, i + 1);
    const RelativePose& pose = result.robust.pose;
    rotation.push_back(Eigen::AngleAxisd(pose.R.transpose() * truth.R).angle() * 180 / M_PI);
    const double cosine = pose.t.normalized().dot(truth.t.normalized());
    direction.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI);
  }
  EXPECT_LT(median(rotation), 0.1);
  EXPECT_LT(median(direction), 2);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PipelineOnScene, ::testing::Values("room", "street"));

}  // namespace
}  // namespace gms_ransac
