// Every method on scenes whose truth is exact, and on data that has no model.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "invariants.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

constexpr ModelType kModels[] = {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography};

RobustOptions optionsFor(ModelType model) {
  RobustOptions options;
  options.model = model;
  options.success_probability = 0.9999;
  options.seed = 7;
  return options;
}

class EveryMethod : public testing::TestWithParam<std::string> {};

/// Errors from 0.3 px of noise in 1000 matches at a share of outliers: 1.5 times those of the worst method.
struct AccuracyLimit {
  double outliers, rotation, direction;  ///< the errors in degrees
};
constexpr AccuracyLimit kAccuracyLimits[] = {{0.1, 0.1, 1.5}, {0.4, 0.075, 0.85}, {0.7, 0.085, 1.2}};
/// Least recall if six tenths or more of the matches are correct; a fundamental matrix from three tenths is rougher.
constexpr double kLeastRecall = 0.98, kLeastRecallOfRough = 0.8;

TEST_P(EveryMethod, FindsTheModelAndThePose) {
  for (ModelType model : kModels) {
    for (const AccuracyLimit& limit : kAccuracyLimits) {
      TwoViewSceneOptions scene;
      scene.outlier_ratio = limit.outliers;
      scene.shape = model == ModelType::kHomography ? SceneShape::kPlane : SceneShape::kVolume;
      const TwoViewScene pair = makeTwoViewScene(scene);
      RobustOptions options = optionsFor(model);
      options.max_iterations = 20000;  // seven points at 70 % outliers ask for 42000 at full confidence
      const RobustResult result = estimated(GetParam(), options, pair);
      SCOPED_TRACE(toString(model) + ", outliers " + std::to_string(limit.outliers));
      ASSERT_TRUE(result.model_found);
      ASSERT_TRUE(result.judgement.pose_found);
      const bool other_motion = result.judgement.evidence[Evidence::kOtherMotion] < 1;
      EXPECT_NE(result.judgement.translation_observable, other_motion);
      EXPECT_TRUE(result.judgement.translation_observable || model == ModelType::kHomography);
      const PoseErrors errors = other_motion ? planePoseErrors(result, pair) : poseErrors(result, pair);
      EXPECT_LT(errors.rotation, limit.rotation);
      EXPECT_LT(errors.direction, limit.direction);
      const auto correct = static_cast<double>(std::count(pair.correct.begin(), pair.correct.end(), 1));
      const bool rough = model == ModelType::kFundamental && limit.outliers > 0.5;
      EXPECT_GT(correctKept(result, pair), (rough ? kLeastRecallOfRough : kLeastRecall) * correct);
      EXPECT_GT(correctKept(result, pair), 0.96 * result.inlier_count);
    }
  }
}

/// A scene that determines the model: a plane for a homography, points in depth for the others; three tenths are wrong.
TwoViewScene sceneFor(ModelType model, int matches = 1000) {
  TwoViewSceneOptions options;
  options.matches = matches;
  options.shape = model == ModelType::kHomography ? SceneShape::kPlane : SceneShape::kVolume;
  return makeTwoViewScene(options);
}

/// Most of what sceneFor() offers was found.
bool isAnswer(const RobustResult& result, const TwoViewScene& scene) {
  return result.model_found && result.judgement.pose_found && result.inlier_count > 0.6 * scene.pairs.size();
}

TEST_P(EveryMethod, KeepsTheMatchesWithinItsThresholdAndNoOther) {
  for (ModelType model : kModels) {
    const TwoViewScene pair = sceneFor(model);
    const RobustOptions options = optionsFor(model);
    const RobustResult result = estimated(GetParam(), options, pair);
    ASSERT_TRUE(isAnswer(result, pair));
    EXPECT_EQ(brokenEstimate(pair.pairs, pair.camera, options, result), "");  // it looks for inliers beyond
    int left_out = 0;
    for (size_t i = 0; i < result.inlier.size(); ++i) {
      const PointPairs& p = pair.pairs;
      const double residual = std::sqrt(
          squaredResidual(pair.camera, result, {p.x_reference[i], p.y_reference[i]}, {p.x_current[i], p.y_current[i]}));
      left_out += !result.inlier[i] && residual < options.inlierThreshold() * (1 - 1e-6);
    }
    EXPECT_EQ(left_out, 0);
  }
}

TEST_P(EveryMethod, RepeatsItselfForASeed) {
  for (ModelType model : kModels) {
    const TwoViewScene pair = sceneFor(model), other = sceneFor(model, 500);
    const auto estimator = makeEstimator(GetParam(), optionsFor(model));
    RobustResult first, between, second;
    estimator->estimate(pair.pairs, pair.camera, first);
    estimator->estimate(other.pairs, other.camera, between);
    estimator->estimate(pair.pairs, pair.camera, second);
    ASSERT_TRUE(isAnswer(first, pair));
    ASSERT_TRUE(isAnswer(between, other));
    EXPECT_EQ(first.inlier, second.inlier);
    EXPECT_EQ(first.model, second.model);
    EXPECT_EQ(first.effort.hypotheses, second.effort.hypotheses);
    EXPECT_EQ(first.effort.point_evaluations, second.effort.point_evaluations);
    EXPECT_EQ(first.inlier, estimated(GetParam(), optionsFor(model), pair).inlier);
  }
}

TEST_P(EveryMethod, StaysHonestOnPureRotation) {
  TwoViewSceneOptions scene;
  scene.translation.setZero();
  const TwoViewScene pair = makeTwoViewScene(scene);
  for (ModelType model : {ModelType::kEssential, ModelType::kHomography}) {
    const RobustResult result = estimated(GetParam(), optionsFor(model), pair);
    ASSERT_TRUE(result.model_found);
    EXPECT_FALSE(result.judgement.translation_observable);
    ASSERT_TRUE(result.judgement.pose_found);
    EXPECT_LT(rotationError(result.judgement.pose.R, pair.R.transpose()), 1.0);
  }
}

TEST_P(EveryMethod, IsNotMisledByPointsWithoutCoordinates) {
  for (ModelType model : kModels) {
    TwoViewSceneOptions scene;
    scene.matches = 500;
    scene.shape = model == ModelType::kHomography ? SceneShape::kPlane : SceneShape::kVolume;
    const TwoViewScene clean = makeTwoViewScene(scene);
    const RobustResult expected = estimated(GetParam(), optionsFor(model), clean);
    for (const float value : {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 1e7f}) {
      for (auto column :
           {&PointPairs::x_reference, &PointPairs::y_reference, &PointPairs::x_current, &PointPairs::y_current}) {
        TwoViewScene spoilt = clean;
        (spoilt.pairs.*column)[77] = value;
        SCOPED_TRACE(toString(model) + " " + std::to_string(value));
        const RobustResult result = estimated(GetParam(), optionsFor(model), spoilt);
        ASSERT_TRUE(result.model_found);
        ASSERT_TRUE(result.judgement.pose_found);
        EXPECT_GT(result.inlier_count, 0.8 * expected.inlier_count);
        EXPECT_EQ(brokenEstimate(spoilt.pairs, spoilt.camera, optionsFor(model), result), "");
        EXPECT_EQ(result.judgement.doubt, expected.judgement.doubt);
        if (result.judgement.doubt != DirectionDoubt::kOtherMotion) {
          EXPECT_LT(rotationError(result.judgement.pose.R, clean.R.transpose()), 2.0);
        }
      }
    }
  }
}

/// Alters a scene into one that has no (single) model.
using Spoil = void (*)(TwoViewScene&);

TEST_P(EveryMethod, FindsNothingInDegenerateData) {
  const Spoil spoilers[] = {
      [](TwoViewScene& pair) { pair.pairs.resize(0); },
      [](TwoViewScene& pair) { pair.pairs.resize(3); },
      [](TwoViewScene& pair) { pair.pairs.resize(7); },
      [](TwoViewScene& pair) {  // one match again and again
        for (auto* column :
             {&pair.pairs.x_reference, &pair.pairs.y_reference, &pair.pairs.x_current, &pair.pairs.y_current}) {
          column->assign(column->size(), column->front());
        }
      },
      [](TwoViewScene& pair) {  // on a line in both images
        pair.pairs.y_reference = pair.pairs.x_reference;
        pair.pairs.y_current = pair.pairs.x_current;
      },
      [](TwoViewScene& pair) {  // not a number
        pair.pairs.x_current.assign(pair.pairs.x_current.size(), std::nanf(""));
      },
      [](TwoViewScene& pair) {  // wrong matches alone
        TwoViewSceneOptions noise;
        noise.outlier_ratio = 1;
        pair = makeTwoViewScene(noise);
      },
  };
  TwoViewSceneOptions scene;
  scene.matches = 200;
  for (const Spoil spoil : spoilers) {
    TwoViewScene pair = makeTwoViewScene(scene);
    spoil(pair);
    for (ModelType model : kModels) {
      const RobustResult result = estimated(GetParam(), optionsFor(model), pair);
      EXPECT_FALSE(result.model_found) << toString(model) << " in case " << &spoil - spoilers;
      EXPECT_FALSE(result.judgement.pose_found);
      EXPECT_EQ(result.inlier_count, 0);
      EXPECT_EQ(result.inlier.size(), static_cast<size_t>(pair.pairs.size()));
    }
  }
}

TEST_P(EveryMethod, RejectsSupportFromTooFewSpotsToCheckIt) {
  TwoViewSceneOptions scene;
  scene.outlier_ratio = 0.1;
  TwoViewScene pair = makeTwoViewScene(scene);
  for (const int side : {640, 10000}) {  // of images that the matches fill, or lie in a corner of
    pair.pairs.image_reference = pair.pairs.image_current = {side, side};
    const RobustResult result = estimated(GetParam(), optionsFor(ModelType::kEssential), pair);
    EXPECT_EQ(result.model_found, side == 640);
    EXPECT_EQ(result.inlier_count > 0, side == 640);
  }
}

TEST_P(EveryMethod, FallsBackToTheFundamentalMatrixWithoutACamera) {
  const TwoViewScene pair = makeTwoViewScene({});
  RobustResult result;
  makeEstimator(GetParam(), optionsFor(ModelType::kEssential))->estimate(pair.pairs, Camera(), result);
  EXPECT_TRUE(result.model_found);
  EXPECT_EQ(result.model_type, ModelType::kFundamental);
  EXPECT_FALSE(result.judgement.pose_found);
}

TEST_P(EveryMethod, GivesACovarianceThatItsErrorsFit) {
  // Squared Mahalanobis distances of the five observable degrees of freedom have a mean of 5 if the covariance is that
  // of an optimal estimate; methods that stop early are allowed more, but not orders of magnitude.
  double sum = 0;
  const int trials = 20;
  for (int trial = 0; trial < trials; ++trial) {
    TwoViewSceneOptions scene;
    scene.seed = 100 + static_cast<uint64_t>(trial);
    scene.outlier_ratio = 0.1;
    const TwoViewScene pair = makeTwoViewScene(scene);
    const RobustResult result = estimated(GetParam(), optionsFor(ModelType::kEssential), pair);
    ASSERT_TRUE(result.judgement.translation_observable);
    const Covariance6d& covariance = result.judgement.pose.covariance;
    EXPECT_NEAR((covariance.topLeftCorner<3, 3>() * result.judgement.pose.t).norm(), 0, 1e-9);
    Eigen::Matrix<double, 6, 1> error;
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(pair.R.transpose() * result.judgement.pose.R.transpose()));
    error << (-pair.R.transpose() * pair.t).normalized() - result.judgement.pose.t, turn.angle() * turn.axis();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(covariance);
    for (int k = 1; k < 6; ++k) {  // the smallest belongs to the direction of t
      sum += std::pow(eigen.eigenvectors().col(k).dot(error), 2) / eigen.eigenvalues()(k);
    }
  }
  EXPECT_LT(sum / trials, 15);
  EXPECT_GT(sum / trials, 1.5);
}

/// Methods that differ from ransac in the filter alone.
const std::set<std::string> kRansacBehindAFilter = {"gms", "gms5", "gms_dist_ransac", "gms_ransac", "lan"};

std::vector<std::string> methodsWithAnEstimateOfTheirOwn() {
  std::vector<std::string> names = methodNames();
  names.erase(std::remove_if(names.begin(), names.end(),
                             [](const std::string& name) { return kRansacBehindAFilter.count(name) > 0; }),
              names.end());
  return names;
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, testing::ValuesIn(methodsWithAnEstimateOfTheirOwn()),
                         [](const auto& info) { return info.param; });

TEST(MethodsThatFilter, EstimateAsRansacDoes) {
  for (const ModelType model : kModels) {
    const TwoViewScene pair = sceneFor(model);
    const RobustResult ransac = estimated("ransac", optionsFor(model), pair);
    for (const std::string& name : kRansacBehindAFilter) {
      SCOPED_TRACE(name + ", " + toString(model));
      const RobustResult result = estimated(name, optionsFor(model), pair);
      EXPECT_EQ(result.model, ransac.model);
      EXPECT_EQ(result.inlier, ransac.inlier);
      EXPECT_EQ(result.judgement.probability, ransac.judgement.probability);
      EXPECT_EQ(result.judgement.pose.covariance, ransac.judgement.pose.covariance);
      EXPECT_EQ(result.effort.point_evaluations, ransac.effort.point_evaluations);
    }
  }
}

TEST(Refinement, BringsThePoseCloserThanTheTextbook) {
  double textbook = 0, refined = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    TwoViewSceneOptions scene;
    scene.seed = seed;
    const TwoViewScene pair = makeTwoViewScene(scene);
    RobustOptions options = optionsFor(ModelType::kEssential);
    refined += rotationError(estimated("gms_ransac", options, pair).judgement.pose.R, pair.R.transpose());
    options.refine = false;
    textbook += rotationError(estimated("gms_ransac", options, pair).judgement.pose.R, pair.R.transpose());
  }
  EXPECT_LT(refined, 0.5 * textbook);
}

TEST(Quality, OfNoiseNeedsMoreHypothesesThanThatOfTheMatches) {
  TwoViewSceneOptions scene;
  scene.outlier_ratio = 0.6;
  const TwoViewScene informed = makeTwoViewScene(scene);
  scene.informative = false;
  const TwoViewScene uninformed = makeTwoViewScene(scene);
  for (const SortKey key : {SortKey::kScore, SortKey::kRelativeScore, SortKey::kDistance}) {
    RobustOptions options = optionsFor(ModelType::kEssential);
    options.sort_key = key;
    EXPECT_LT(estimated("cp_ransac", options, informed).effort.hypotheses,
              estimated("cp_ransac", options, uninformed).effort.hypotheses)
        << static_cast<int>(key);
  }
}

}  // namespace
}  // namespace gms_ransac
