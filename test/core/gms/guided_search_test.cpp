// Guided search: no fewer right matches than a full one, the same as a full one where there is no common motion, and
// the same on every instruction set.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "datasets/dataset.h"
#include "gms/guided_search.h"
#include "gms/motion_prediction.h"
#include "gms_ransac/match_filter.h"
#include "rendered_scene.h"
#include "run/metrics.h"
#include "run/pair_truth.h"
#include "scenes/synthetic_pair.h"
#include "shared_data.h"
#include "simd_levels.h"

namespace gms_ransac {
namespace {

bool same(const std::vector<Match>& a, const std::vector<Match>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Match& x, const Match& y) {
    return x.reference == y.reference && x.current == y.current && x.distance == y.distance &&
           x.second_distance == y.second_distance;
  });
}

constexpr uint64_t kRoom = 3, kOtherRoom = 4;  // seeds

const Scene& room() { return renderedScene("room", kRoom); }
const cv::Mat& view(int frame, uint64_t seed = kRoom) { return renderedFrame(frame, "room", seed).image; }

Features extract(const cv::Mat& image, int count = 2000) {
  FeatureExtractorOptions options;
  options.features = count;
  Features features;
  makeFeatureExtractor(options)->extract(image, features);
  return features;
}

std::vector<Match> matchFully(const Features& reference, const Features& current) {
  std::vector<Match> matches;
  HammingMatcher().match(reference.descriptors, current.descriptors, matches);
  return matches;
}

std::vector<Match> matchGuided(const Features& reference, const Features& current,
                               const HammingMatcherOptions& options = {}, const MotionPrediction* prior = nullptr) {
  std::vector<Match> matches;
  GuidedSearch(options, {}).match(reference, current, matches, prior);
  return matches;
}

/// Matches that end within 3 px of where the point is.
int countRight(const std::vector<Match>& matches, const Features& reference, const Features& current,
               const Scene& scene, int to) {
  return static_cast<int>(std::count_if(matches.begin(), matches.end(), [&](const Match& match) {
    const cv::Point2f& a = reference.keypoints[static_cast<size_t>(match.reference)].pt;
    const cv::Point2f& b = current.keypoints[static_cast<size_t>(match.current)].pt;
    cv::Point2d truth;
    return scene.correspondence(0, cv::Point2d(a), to, truth) && cv::norm(truth - cv::Point2d(b)) < 3;
  }));
}

TEST(GuidedSearch, FindsNoFewerRightMatches) {
  const Features reference = extract(view(0));
  for (const int gap : {1, 4}) {
    const Features current = extract(view(gap));
    const std::vector<Match> full = matchFully(reference, current), guided = matchGuided(reference, current);
    EXPECT_LT(guided.size(), full.size());  // it was guided
    const int right = countRight(full, reference, current, room(), gap);
    EXPECT_GT(right, 500);
    EXPECT_GE(countRight(guided, reference, current, room(), gap), 0.99 * right) << "gap " << gap;
  }
}

TEST(GuidedSearch, KeepsTheOrderOfTheReference) {
  const std::vector<Match> matches = matchGuided(extract(view(0)), extract(view(1)));
  for (size_t i = 1; i < matches.size(); ++i) EXPECT_LT(matches[i - 1].reference, matches[i].reference);
  for (const Match& match : matches) EXPECT_GE(match.second_distance, match.distance);
}

TEST(GuidedSearch, IsFullWhereNothingMovesTogether) {
  const Features reference = extract(view(0)), other = extract(view(0, kOtherRoom));
  EXPECT_TRUE(same(matchFully(reference, other), matchGuided(reference, other)));
}

TEST(GuidedSearch, IsFullWithFewKeypoints) {
  const Features reference = extract(view(0), 500), current = extract(view(1), 500);
  EXPECT_TRUE(same(matchFully(reference, current), matchGuided(reference, current)));
}

TEST(GuidedSearch, TakesImagesWithoutKeypoints) {
  const Features some = extract(view(0)), none = extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(90)));
  EXPECT_EQ(0, none.size());
  EXPECT_TRUE(matchGuided(some, none).empty());
  EXPECT_TRUE(matchGuided(none, some).empty());
}

TEST(GuidedSearch, IsTheSameOnEveryInstructionSetAndForAnyNumberOfThreads) {
  const Features reference = extract(view(0)), current = extract(view(4));
  const std::vector<Match> expected = matchGuided(reference, current, {false, 1, SimdLevel::kScalar});
  for (const SimdLevel level : supportedLevels()) {
    for (const int threads : {1, 2, 5}) {
      EXPECT_TRUE(same(expected, matchGuided(reference, current, {false, threads, level}))) << toString(level);
    }
  }
}

TEST(GuidedSearch, RefusesMutualNeighbours) { EXPECT_THROW(GuidedSearch({true}, {}), std::invalid_argument); }

/// One cell for the whole image, without motion.
MotionPrediction standstill() {
  MotionPrediction prior;
  prior.columns = prior.rows = 1;
  CellMotion motion;
  motion.known = true;
  motion.reach = {20, 20};
  prior.cells = {motion};
  return prior;
}

TEST(GuidedSearch, DoesNotBelieveAPriorThatTheMatchesContradict) {
  const Features reference = extract(view(0)), current = extract(view(4));
  const MotionPrediction prior = standstill();
  const int without = countRight(matchGuided(reference, current), reference, current, room(), 4);
  EXPECT_GE(countRight(matchGuided(reference, current, {}, &prior), reference, current, room(), 4), 0.99 * without);
}

TEST(GuidedSearch, DoesNotBelieveAPriorThatNothingConfirms) {
  const Features reference = extract(view(0)), other = extract(view(0, kOtherRoom));
  const MotionPrediction prior = standstill();
  EXPECT_TRUE(same(matchFully(reference, other), matchGuided(reference, other, {}, &prior)));
}

// A gyro measures the rotation of the camera.

/// The room, seen by a camera that rotates on the spot by so many degrees a frame.
Scene roomFromRotatingCamera(double degrees, const std::vector<double>& distortion = {}) {
  SceneOptions options = room().options();
  options.step = options.sway = 0;
  options.turn = degrees;
  options.distortion = distortion;
  return Scene(options);
}

RotationPrior gyroOf(const Scene& scene, int from, int to) {
  constexpr double kSigma = 0.1 * M_PI / 180;
  RotationPrior prior;
  prior.R = trueRelativePose(scene, from, to).R;
  prior.covariance = kSigma * kSigma * Eigen::Matrix3d::Identity();
  return prior;
}

/// Rotations of three wrong gyros when the true one measures `right`.
std::vector<RotationPrior> wrongGyros(const RotationPrior& right) {
  const Eigen::AngleAxisd rotation(right.R);
  const Eigen::Vector3d axis = rotation.axis();
  std::vector<RotationPrior> wrong(3, right);
  wrong[0].R = Eigen::AngleAxisd(rotation.angle(), Eigen::Vector3d(axis.y(), axis.z(), axis.x())).toRotationMatrix();
  wrong[1].R = Eigen::Matrix3d::Identity();  // delayed: it shows no rotation yet
  wrong[2].R = right.R.transpose();
  return wrong;
}

TEST(RotationPrediction, SaysWhereARotationTakesPoints) {
  for (const auto& distortion : {std::vector<double>(), std::vector<double>{-0.28, 0.07, 0.0002, 0.00002, 0}}) {
    const Scene scene = roomFromRotatingCamera(10, distortion);
    MotionPrediction prediction;
    predictRotation(gyroOf(scene, 0, 1), cameraOf(scene), prediction);
    int points = 0;
    for (int y = 0; y < 480; y += 16) {
      for (int x = 0; x < 640; x += 16) {
        const cv::Point2f from(static_cast<float>(x), static_cast<float>(y));
        cv::Point2d truth;
        const CellMotion* motion = prediction.at(from, scene.options().size);
        if (!motion->known || !scene.correspondence(0, from, 1, truth)) continue;
        EXPECT_LT(cv::norm(cv::Point2d(motion->predict(from)) - truth), 4) << x << ", " << y;
        ++points;
      }
    }
    EXPECT_GT(points, 600);
  }
}

MatchFilterOptions optionsOf(SearchMode search) {
  MatchFilterOptions options;
  options.search = search;
  return options;
}

TEST(GuidedSearch, AGyroLosesNoMatchAndAWrongOneChangesNone) {
  for (const double degrees : {5, 25, 35, 45}) {
    SCOPED_TRACE(degrees);
    const Scene scene = roomFromRotatingCamera(degrees);
    MatchFilter full(optionsOf(SearchMode::kFull)), guided(optionsOf(SearchMode::kGuided));
    Frame reference, current;
    full.extract(scene.render(0).image, reference);
    full.extract(scene.render(1).image, current);
    const auto matches = [&](MatchFilter& filter, const RotationPrior* prior) {
      MatchResult result;
      filter.setCamera(cameraOf(scene));
      filter.reset();
      filter.filter(reference, current, result, prior);
      return result.matches;
    };
    const auto right = [&](const std::vector<Match>& found) {
      return countRight(found, reference.features, current.features, scene, 1);
    };
    const RotationPrior gyro = gyroOf(scene, 0, 1);
    const std::vector<Match> alone = matches(guided, nullptr);
    const int with = right(matches(guided, &gyro));
    EXPECT_GE(with, right(alone));
    EXPECT_GE(with, 0.99 * right(matches(full, nullptr)));
    for (const RotationPrior& wrong : wrongGyros(gyro)) EXPECT_TRUE(same(alone, matches(guided, &wrong)));
  }
}

// Real images, and a gyro drawn from their true rotation with the error that the truth may have.

RotationPrior gyroOf(const Eigen::Isometry3d& current_in_reference, double degrees, std::mt19937& random) {
  const double sigma = degrees / kDegrees;
  std::normal_distribution<double> error(0, sigma);
  const Eigen::Vector3d drawn(error(random), error(random), error(random));
  RotationPrior prior;
  prior.R = Eigen::AngleAxisd(drawn.norm(), drawn.normalized()) * current_in_reference.rotation();
  prior.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  return prior;
}

TEST(RealTurns, AGyroLosesNoRightMatches) {
  OPEN_OR_SKIP(dataset, "tum_fr1_rpy");
  MatchFilter filter(optionsOf(SearchMode::kGuided));
  const Camera camera(*dataset->intrinsics(), dataset->image(0).size());
  filter.setCamera(camera);
  std::mt19937 random(1);
  int pairs = 0;
  MatchCounts alone, with;
  for (const DatasetPair& pair : dataset->pairs(10, 10)) {
    const PairTruth truth(*dataset, pair, camera);
    if (!truth.currentInReference()) continue;
    ++pairs;
    Frame reference, current;
    filter.extract(dataset->image(pair.reference), reference);
    filter.extract(dataset->image(pair.current), current);
    const auto compare = [&](const RotationPrior* prior, MatchCounts* sum) {
      MatchResult result;
      filter.reset();
      filter.filter(reference, current, result, prior);
      const MatchCounts counts = countEpipolar(truth, reference.features, current.features, result);
      sum->raw_correct += counts.raw_correct;
      sum->kept_correct += counts.kept_correct;
      return result.matches;
    };
    RotationPrior gyro = gyroOf(*truth.currentInReference(), 0.3, random);
    const std::vector<Match> found = compare(nullptr, &alone);
    compare(&gyro, &with);
    gyro.R.transposeInPlace();
    MatchCounts mirrored;
    EXPECT_TRUE(same(found, compare(&gyro, &mirrored)));
  }
  EXPECT_EQ(5, pairs);
  EXPECT_GE(with.raw_correct, 0.99 * alone.raw_correct);
  EXPECT_GE(with.kept_correct, 0.99 * alone.kept_correct);
}

/// Statuses and poses of a stream, once with each search.
class StreamOfBoth : public testing::Test {
 protected:
  StreamOfBoth() {
    for (MatchFilter* filter : {&full_, &guided_}) filter->setCamera(cameraOf(room()));
  }
  /// Status of the pair that the image ends; the same with both.
  Status see(const cv::Mat& image) {
    const Status expected = full_.process(image).status;
    const MatchResult& result = guided_.process(image);
    EXPECT_EQ(expected, result.status);
    return result.status;
  }
  MatchFilter full_{optionsOf(SearchMode::kFull)}, guided_{optionsOf(SearchMode::kGuided)};
};

TEST_F(StreamOfBoth, SurvivesACut) {
  EXPECT_EQ(Status::kFirstFrame, see(view(0)));
  EXPECT_EQ(Status::kOk, see(view(1)));
  EXPECT_NE(Status::kOk, see(view(0, kOtherRoom)));
  EXPECT_EQ(Status::kOk, see(view(1, kOtherRoom)));
}

TEST_F(StreamOfBoth, SurvivesAFlash) {
  see(view(0));
  cv::Mat flash;
  view(1).convertTo(flash, CV_8U, 0.3, 170);
  see(flash);
  see(view(2));
  see(cv::Mat(room().options().size, CV_8UC1, cv::Scalar(255)));
  EXPECT_NE(Status::kOk, see(view(3)));
  EXPECT_EQ(Status::kOk, see(view(4)));
}

}  // namespace
}  // namespace gms_ransac
