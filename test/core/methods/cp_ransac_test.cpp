// The method of the paper where its confident matches are crowded, against uniform samples.
#include <algorithm>

#include <gtest/gtest.h>

#include "two_view_scene.h"

namespace gms_ransac {
namespace {

void append(const PointPairs& from, PointPairs& to) {
  const auto add = [&](auto column) {
    (to.*column).insert((to.*column).end(), (from.*column).begin(), (from.*column).end());
  };
  for (const auto column : {&PointPairs::x_reference, &PointPairs::y_reference, &PointPairs::x_current,
                            &PointPairs::y_current, &PointPairs::relative_score}) {
    add(column);
  }
  for (const auto column : {&PointPairs::octave_reference, &PointPairs::octave_current}) add(column);
  for (const auto column : {&PointPairs::distance, &PointPairs::second_distance}) add(column);
  add(&PointPairs::score);
}

/// Half of the matches are crowded in the middle of the image and the more confident.
TwoViewScene crowdedScene(uint64_t seed) {
  TwoViewSceneOptions options;
  options.seed = seed;
  options.matches = 100;
  TwoViewScene scene = makeTwoViewScene(options);
  options.seed = seed + 1000;
  options.outlier_ratio = 0.05;
  options.image_share = 0.08;
  TwoViewScene crowd = makeTwoViewScene(options);
  std::fill(scene.pairs.relative_score.begin(), scene.pairs.relative_score.end(), 1.f);
  std::fill(crowd.pairs.relative_score.begin(), crowd.pairs.relative_score.end(), 2.f);
  append(crowd.pairs, scene.pairs);
  return scene;
}

struct Answers {
  int right = 0, hypotheses = 0;
};

Answers answersTo(int scenes, const std::string& method) {
  const auto estimator = makeEstimator(method, {});
  Answers answers;
  for (int seed = 1; seed <= scenes; ++seed) {
    const TwoViewScene scene = crowdedScene(static_cast<uint64_t>(seed));
    const RobustResult result = estimated(*estimator, scene);
    answers.hypotheses += result.effort.hypotheses;
    const PoseErrors errors = poseErrors(result, scene);
    answers.right += result.judgement.translation_observable && errors.rotation < 1 && errors.direction < 5;
  }
  return answers;
}

TEST(CpRansac, IsRightWhereUniformSamplesAreThoughTheConfidentAreCrowded) {
  constexpr int kScenes = 60;
  const Answers confident = answersTo(kScenes, "cp_ransac"), uniform = answersTo(kScenes, "gms_ransac");
  EXPECT_GE(confident.right, uniform.right - kScenes / 20);
  EXPECT_GT(uniform.right, kScenes / 2);
}

TEST(CpRansac, IsLiteralWithoutTheJudgement) {
  RobustOptions literal;
  literal.judge = false;
  int fewer = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    const TwoViewScene scene = crowdedScene(seed);
    const int drawn = estimated("cp_ransac", literal, scene).effort.hypotheses;
    const int judged = estimated("cp_ransac", {}, scene).effort.hypotheses;
    EXPECT_LE(drawn, judged);
    fewer += drawn < judged;
  }
  EXPECT_GT(fewer, 0);
}

}  // namespace
}  // namespace gms_ransac
