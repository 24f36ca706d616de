// Guided search: no fewer right matches than a full one, the same as a full one where there is no common motion, and
// the same on every instruction set.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "gms/guided_search.h"
#include "gms/motion_prediction.h"
#include "gms_ransac/match_filter.h"
#include "rendered_scene.h"
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
                               const HammingMatcherOptions& options = {}) {
  std::vector<Match> matches;
  GuidedSearch(options, {}).match(reference, current, matches);
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

TEST(GuidedSearch, FindsNoFewerRightMatchesInTheOrderOfTheReference) {
  const Features reference = extract(view(0));
  for (const int gap : {1, 4}) {
    const Features current = extract(view(gap));
    const std::vector<Match> full = matchFully(reference, current), guided = matchGuided(reference, current);
    EXPECT_LT(guided.size(), full.size());  // it was guided
    for (size_t i = 1; i < guided.size(); ++i) EXPECT_LT(guided[i - 1].reference, guided[i].reference);
    for (const Match& match : guided) EXPECT_GE(match.second_distance, match.distance);
    const int right = countRight(full, reference, current, room(), gap);
    EXPECT_GT(right, 500);
    EXPECT_GE(countRight(guided, reference, current, room(), gap), 0.99 * right) << "gap " << gap;
  }
}

TEST(GuidedSearch, IsFullWhereNothingMovesTogetherAndWithFewKeypoints) {
  const Features reference = extract(view(0)), other = extract(view(0, kOtherRoom));
  EXPECT_TRUE(same(matchFully(reference, other), matchGuided(reference, other)));
  const Features few = extract(view(0), 500), next = extract(view(1), 500);
  EXPECT_TRUE(same(matchFully(few, next), matchGuided(few, next)));
  EXPECT_TRUE(matchGuided(reference, Features()).empty());
  EXPECT_TRUE(matchGuided(Features(), reference).empty());
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
        if (!motion || !scene.correspondence(0, from, 1, truth)) continue;
        EXPECT_LT(cv::norm(cv::Point2d(motion->predict(from)) - truth), 4) << x << ", " << y;
        ++points;
      }
    }
    EXPECT_GT(points, 600);
  }
}

TEST(GuidedSearch, AGyroLosesNoMatchAndAWrongOneChangesNone) {
  for (const double degrees : {5, 25, 35, 45}) {
    SCOPED_TRACE(degrees);
    const Scene scene = roomFromRotatingCamera(degrees);
    MatchFilterOptions options;
    MatchFilter guided(options);
    options.search = SearchMode::kFull;
    MatchFilter full(options);
    Frame reference, current;
    full.extract(scene.render(0).image, reference);
    full.extract(scene.render(1).image, current);
    const auto matches = [&](MatchFilter& filter, const RotationPrior* prior) {
      MatchResult result;
      filter.setCamera(cameraOf(scene));
      filter.filter(reference, current, result, prior);
      return result.raw;
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

}  // namespace
}  // namespace gms_ransac
