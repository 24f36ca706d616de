// The pipeline as its callers see it.
#include "gms_ransac/match_filter.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "gms_ransac/triangulation.h"
#include "match_filter_hooks.h"
#include "methods/method.h"
#include "parameters/parameter.h"
#include "rendered_scene.h"
#include "stages.h"

namespace gms_ransac {
namespace {

TEST(MatchFilter, RefusesAnUnknownMethodWithTheKnownOnes) {
  MatchFilterOptions options;
  options.method = "nonsense";
  try {
    MatchFilter filter(options);
    FAIL() << "accepted an unknown method";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("cp_ransac"), std::string::npos);
  }
}

TEST(MatchFilter, RefusesWhatIsNoNumberAndThreadsItDoesNotHave) {
  const auto refuses = [](auto&& spoil) {
    MatchFilterOptions options;
    spoil(options);
    EXPECT_THROW(options.validate(), std::invalid_argument);
    EXPECT_THROW(MatchFilter{options}, std::invalid_argument);
  };
  for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    refuses([=](MatchFilterOptions& o) { o.extractor.pyramid_scale = value; });
    refuses([=](MatchFilterOptions& o) { o.motion_statistics.threshold_factor = value; });
    refuses([=](MatchFilterOptions& o) { o.lan_second_threshold_factor = value; });
    refuses([=](MatchFilterOptions& o) { o.robust.inlier_threshold_px = value; });
    refuses([=](MatchFilterOptions& o) { o.robust.target_inlier_ratio = value; });
    for (double RobustOptions::*field : {&RobustOptions::success_probability, &RobustOptions::first_group_fraction,
                                         &RobustOptions::subset_fraction, &RobustOptions::split_fraction}) {
      refuses([=](MatchFilterOptions& o) { o.robust.*field = value; });
    }
  }
  for (const int threads : {-1, 0, 65, 1000}) {
    refuses([=](MatchFilterOptions& o) { o.matcher_threads = threads; });
  }
  EXPECT_NO_THROW(MatchFilterOptions().validate());
}

TEST(MatchFilter, FirstImageHasNothingToCompareWith) {
  MatchFilter filter;
  EXPECT_EQ(filter.process(cv::Mat::zeros(480, 640, CV_8UC1)).status, Status::kFirstFrame);
  EXPECT_EQ(filter.process(cv::Mat::zeros(480, 640, CV_8UC1)).status, Status::kTooFewKeypoints);
}

class EstimateAgain : public testing::TestWithParam<const char*> {};

TEST_P(EstimateAgain, AsIfTheSeedHadBeenGivenFirst) {
  cv::Mat texture(300, 400, CV_8UC1), image, moved;
  cv::RNG(1).fill(texture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(texture, texture, cv::Size(), 2.0);
  cv::normalize(texture, image, 0, 255, cv::NORM_MINMAX);
  const cv::Matx33d motion(0.98, -0.1, 30, 0.1, 0.98, -12, 1e-5, 2e-5, 1);
  cv::warpPerspective(image, moved, motion, image.size());

  MatchFilterOptions options;
  options.method = GetParam();
  options.robust.model = ModelType::kHomography;
  options.robust.max_iterations = 5;  // few enough that seeds differ
  options.robust.seed = 7;
  MatchFilter expected_filter(options);
  options.robust.seed = 0;
  MatchFilter filter(options);
  Frame reference, current;
  filter.extract(image, reference);
  filter.extract(moved, current);
  MatchResult expected, result;
  expected_filter.filter(reference, current, expected);
  filter.filter(reference, current, result);
  MatchFilterHooks::setSeed(filter, 7);
  MatchFilterHooks::estimate(filter, reference, current, result);
  EXPECT_GT(expected.inliers, 0);
  EXPECT_EQ(result.status, expected.status);
  EXPECT_EQ(result.inliers, expected.inliers);
  EXPECT_EQ(stagesOf(result), stagesOf(expected));
  EXPECT_EQ(result.robust.model, expected.robust.model);

  // The result holds all inputs of the estimate: a filter that never saw the pair gives the same.
  result.clear(result.status);
  filter.filter(reference, current, result);
  options.robust.seed = 7;
  MatchFilter other(options);
  MatchFilterHooks::estimate(other, reference, current, result);
  EXPECT_EQ(stagesOf(result), stagesOf(expected));
  EXPECT_EQ(result.robust.judgement.probability, expected.robust.judgement.probability);
  EXPECT_EQ(result.robust.model, expected.robust.model);
}

INSTANTIATE_TEST_SUITE_P(Methods, EstimateAgain, testing::Values("ransac", "gms", "lan"));

/// Random rectangles, and the same seen from four pixels to the right with a strip that moves by itself.
std::pair<cv::Mat, cv::Mat> shiftedPair() {
  cv::Mat wide(480, 700, CV_8UC1, cv::Scalar(90));
  cv::RNG random(5);
  for (int i = 0; i < 900; ++i) {
    const cv::Point corner(random.uniform(0, 690), random.uniform(0, 470));
    const cv::Size size(random.uniform(5, 40), random.uniform(5, 40));
    cv::rectangle(wide, cv::Rect(corner, size), cv::Scalar(random.uniform(0, 255)), cv::FILLED);
  }
  cv::Mat second = wide(cv::Rect(4, 0, 640, 480)).clone();
  wide(cv::Rect(30, 400, 640, 60)).copyTo(second(cv::Rect(0, 400, 640, 60)));
  return {wide(cv::Rect(0, 0, 640, 480)).clone(), second};
}

MatchResult resultOf(const MatchFilterOptions& options) {
  MatchFilter filter(options);
  const auto [first, second] = shiftedPair();
  filter.process(first);
  return filter.process(second);
}

TEST(MatchFilter, TheNewestSeedIsThatOfEveryStage) {
  const cv::Mat first = renderedFrame(0).image, second = renderedFrame(4).image;
  for (const MethodEntry& method : methods()) {
    MatchFilterOptions options;
    options.method = method.name;
    options.distance_reading = DistanceReading::kPairwise;  // the reading that draws partners
    MatchFilter filter(options);
    Frame reference, current;
    filter.extract(first, reference);
    filter.extract(second, current);
    MatchResult expected, result, other;
    filter.filter(reference, current, other);
    filter.reset();
    MatchFilterHooks::setSeed(filter, 7);
    filter.filter(reference, current, result);
    options.robust.seed = 7;
    MatchFilter(options).filter(reference, current, expected);
    EXPECT_EQ(stagesOf(result), stagesOf(expected)) << method.name;
    EXPECT_EQ(result.robust.judgement.probability, expected.robust.judgement.probability) << method.name;
    if (method.name == std::string("gms_dist_ransac")) {
      EXPECT_NE(other.pairs.x_current, expected.pairs.x_current) << "the seeds draw the same partners";
      EXPECT_EQ(result.pairs.x_current, expected.pairs.x_current);
    }
  }
}

TEST(RobustResult, RejectedHasNoModelAndNoPose) {
  RobustResult result;
  result.model_found = result.judgement.pose_found = result.judgement.translation_observable = true;
  result.model.setIdentity();
  result.judgement.pose.t = {1, 0, 0};
  result.judgement.pose.covariance.setIdentity();
  result.inlier = {1};
  result.inlier_count = 1;
  result.effort.hypotheses = 7;
  result.reject();
  EXPECT_FALSE(result.model_found || result.judgement.pose_found || result.judgement.translation_observable);
  EXPECT_TRUE(result.model.isZero() && result.judgement.pose.t.isZero() && result.judgement.pose.covariance.isZero());
  EXPECT_EQ(result.inlier, std::vector<uint8_t>{0});
  EXPECT_EQ(result.effort.hypotheses, 7);
}

TEST(MatchFilter, FindsTheMotionOfSensorsOfFewPixels) {
  cv::Mat wide;
  cv::resize(renderedFrame(0).image, wide, cv::Size(), 0.25, 0.25, cv::INTER_AREA);
  for (const cv::Size size : {cv::Size(32, 24), cv::Size(64, 48), cv::Size(64, 64), cv::Size(80, 60)}) {
    for (const char* extractor : {"simd_orb", "opencv"}) {
      // The border of cv::ORB, 31 pixels, is more than such an image has.
      if (extractor == std::string("opencv") && size.height < 48) continue;
      SCOPED_TRACE(std::string(extractor) + " " + std::to_string(size.width) + "x" + std::to_string(size.height));
      MatchFilterOptions options;
      options.extractor.extractor = extractor;
      options.robust.model = ModelType::kHomography;
      MatchFilter filter(options);
      constexpr int kShift = 3;
      const cv::Rect first(40, 30, size.width, size.height);
      filter.process(wide(first));
      const MatchResult& result = filter.process(wide(first + cv::Point(kShift, 0)));
      EXPECT_EQ(filter.current().features.image_size, size);
      ASSERT_EQ(result.status, Status::kUncalibrated);
      const Eigen::Matrix3d H = result.robust.model / result.robust.model(2, 2);
      EXPECT_NEAR(H(0, 2), -kShift, 0.3);
      EXPECT_NEAR(H(1, 2), 0, 0.3);

      cv::Mat mask(size, CV_8UC1, cv::Scalar(0));
      mask.colRange(size.width / 2, size.width).setTo(255);
      filter.reset();
      filter.process(wide(first), mask);
      EXPECT_GT(filter.current().features.size(), 0);
      for (const cv::KeyPoint& keypoint : filter.current().features.keypoints) {
        EXPECT_GE(keypoint.pt.x, 0.5f * static_cast<float>(size.width) - 1);
        EXPECT_LT(keypoint.pt.x, static_cast<float>(size.width));
      }
    }
  }
}

TEST(MatchFilter, RefusesImagesOfAnotherSizeThanTheCamera) {
  MatchFilter filter;
  const cv::Mat images[] = {renderedFrame(0).image, renderedFrame(1).image};
  filter.setCamera(cameraOf(renderedScene()));
  filter.process(images[0]);
  const auto refusal = [&](const auto& call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const std::string sentence =
      "MatchFilter: the image is 320 x 240 pixels, the camera 640 x 480; set the camera of these images";
  const cv::Mat small = images[1](cv::Rect(0, 0, 320, 240));
  EXPECT_EQ(refusal([&] { filter.process(small); }), sentence);
  Frame reference, current;
  MatchResult result;
  filter.extract(small, reference);
  filter.extract(small, current);
  EXPECT_EQ(refusal([&] { filter.filter(reference, current, result); }), sentence);
  EXPECT_EQ(refusal([&] { filter.process(reference.features); }), sentence);
  EXPECT_EQ(filter.process(images[1]).status, Status::kOk) << "the sequence goes on from the image before";
}

TEST(MatchFilter, OfAProcessedPairHasKeypointsAndTracks) {
  MatchFilter filter;
  filter.setCamera(cameraOf(renderedScene()));
  filter.process(renderedFrame(0).image);
  EXPECT_EQ(filter.reference().features.size(), 0);
  std::map<uint32_t, cv::Point2f> last;
  for (int i = 1; i < 4; ++i) {
    const MatchResult& result = filter.process(renderedFrame(i).image);
    const Features &reference = filter.reference().features, &current = filter.current().features;
    ASSERT_EQ(result.track_id.size(), result.matches.size());
    Triangulation points;
    triangulateInliers(reference, result, filter.camera(), points);
    EXPECT_EQ(points.size(), result.inliers);
    std::map<uint32_t, cv::Point2f> now;
    int carried_on = 0;
    for (size_t row = 0; row < result.matches.size(); ++row) {
      const cv::Point2f from = reference.keypoints[static_cast<size_t>(result.matches[row].reference)].pt;
      EXPECT_EQ(result.track_id[row] != 0, result.isInlier(row));
      if (result.track_id[row] == 0) continue;
      now[result.track_id[row]] = current.keypoints[static_cast<size_t>(result.matches[row].current)].pt;
      const auto before = last.find(result.track_id[row]);
      if (before == last.end()) continue;
      EXPECT_EQ(before->second, from);
      EXPECT_GE(result.track_length[row], 3);
      ++carried_on;
    }
    EXPECT_EQ(carried_on > 100, i > 1);
    last = now;
  }
}

MatchFilterOptions optionsOf(const std::string& method, ModelType model = ModelType::kHomography) {
  MatchFilterOptions options;
  options.method = method;
  options.robust.model = model;
  return options;
}

TEST(MatchFilter, GmsAloneKeepsItsSurvivorsWhateverTheModelSays) {
  for (const char* method : {"gms", "gms5"}) {
    const MatchResult result = resultOf(optionsOf(method));
    EXPECT_GT(result.size(), 200) << method;
    EXPECT_EQ(result.inliers, result.size()) << method;
    EXPECT_GT(result.inliers, result.robust.inlier_count) << method;  // the strip breaks the homography
  }
  const MatchResult estimated = resultOf(optionsOf("gms_ransac"));
  EXPECT_EQ(estimated.inliers, estimated.robust.inlier_count);
}

TEST(MatchFilter, EveryModelWeighsItsMatches) {
  for (const ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    for (const char* method : {"lo_prosac", "cp_ransac", "gms", "lan", "ransac"}) {
      const MatchResult result = resultOf(optionsOf(method, model));
      const std::string what = toString(model) + std::string(" of ") + method;
      ASSERT_TRUE(result.robust.model_found) << what;
      ASSERT_EQ(result.robust.judgement.probability.size(), result.matches.size()) << what;
      int right = 0;
      for (size_t i = 0; i < result.matches.size(); ++i) {
        const float probability = result.probability(i);
        EXPECT_TRUE(probability >= 0 && probability <= 1) << what << " " << i;
        right += result.isInlier(i) && probability > 0.5f;
      }
      EXPECT_GT(right, result.robust.inlier_count / 2) << what;
      EXPECT_GT(result.robust.judgement.sigma_px, 0) << what;
      EXPECT_GE(result.robust.judgement.sigma(7, 1.2f), result.robust.judgement.sigma(0, 1.2f)) << what;
    }
  }
}

TEST(MatchFilter, MotionStatisticsRunOnlyForMethodsThatUseThem) {
  const auto tells = [](const MatchResult& result) {
    return std::set<float>(result.confidence.begin(), result.confidence.end());
  };
  for (const char* method : {"ransac", "rransac_tdd", "prosac", "subset_ransac", "split2080"}) {
    EXPECT_EQ(tells(resultOf(optionsOf(method))), std::set<float>{1.f}) << method << " has no scores";
  }
  EXPECT_GT(tells(resultOf(optionsOf("gms_ransac"))).size(), 1u);
  MatchFilterOptions by_score = optionsOf("prosac");
  by_score.robust.sort_key = SortKey::kScore;
  EXPECT_GT(tells(resultOf(by_score)).size(), 1u) << "sorted by scores that are not there";
}

TEST(MatchFilter, AllMatchesMayBeSampled) {
  MatchFilterOptions options = optionsOf("split2080");
  options.robust.split_fraction = 1;
  const MatchResult result = resultOf(options);
  EXPECT_TRUE(result.robust.model_found);
  EXPECT_GT(result.inliers, 100);
}

TEST(MatchFilter, LanChecksItsInliersAgain) {
  MatchFilterOptions options = optionsOf("lan");
  const MatchResult mutual = resultOf(options);
  EXPECT_LT(mutual.raw.size(), static_cast<size_t>(mutual.keypoints_reference));
  EXPECT_GT(mutual.inliers, 100);
  options.lan_second_threshold_factor = 100;  // nothing can have so much support
  const MatchResult unsupported = resultOf(options);
  EXPECT_EQ(unsupported.inliers, 0);
  EXPECT_EQ(unsupported.status, Status::kRansacFailed);
  EXPECT_FALSE(unsupported.robust.judgement.pose_found);
  options.lan_second_threshold_factor.reset();
  options.lan_mutual = false;
  options.search = SearchMode::kFull;
  const MatchResult one_way = resultOf(options);
  EXPECT_EQ(one_way.raw.size(), static_cast<size_t>(one_way.keypoints_reference));
}

}  // namespace
}  // namespace gms_ransac
