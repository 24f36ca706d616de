// Guided search: no fewer right matches than a full one, the same as a full one where there is no common motion, and
// the same on every instruction set.
#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "gms_ransac/guided_search.h"
#include "gms_ransac/match_filter.h"
#include "gms_ransac/motion_prediction.h"
#include "scenes/scene.h"

namespace gms_ransac {
namespace {

bool same(const std::vector<Match>& a, const std::vector<Match>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Match& x, const Match& y) {
    return x.reference == y.reference && x.current == y.current && x.distance == y.distance &&
           x.second_distance == y.second_distance;
  });
}

SceneOptions sceneOptions(const std::string& name, uint64_t seed = 3) {
  SceneOptions options;
  options.scene = name;
  options.seed = seed;
  return options;
}

const Scene& room() {
  static const Scene scene(sceneOptions("room"));
  return scene;
}

const Scene& otherRoom() {
  static const Scene scene(sceneOptions("room", 4));
  return scene;
}

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

/// Matches that end within 3 px of where the point is, of frames of the room.
int countRight(const std::vector<Match>& matches, const Features& reference, const Features& current, int from,
               int to) {
  return static_cast<int>(std::count_if(matches.begin(), matches.end(), [&](const Match& match) {
    const cv::Point2f& a = reference.keypoints[static_cast<size_t>(match.reference)].pt;
    const cv::Point2f& b = current.keypoints[static_cast<size_t>(match.current)].pt;
    cv::Point2d truth;
    return room().correspondence(from, cv::Point2d(a), to, truth) && cv::norm(truth - cv::Point2d(b)) < 3;
  }));
}

TEST(GuidedSearch, FindsNoFewerRightMatches) {
  const Features reference = extract(room().render(0).image);
  for (const int gap : {1, 4}) {
    const Features current = extract(room().render(gap).image);
    const std::vector<Match> full = matchFully(reference, current), guided = matchGuided(reference, current);
    EXPECT_LT(guided.size(), full.size());  // it was guided
    const int right = countRight(full, reference, current, 0, gap);
    EXPECT_GT(right, 500);
    EXPECT_GE(countRight(guided, reference, current, 0, gap), 0.99 * right) << "gap " << gap;
  }
}

TEST(GuidedSearch, KeepsTheOrderOfTheReference) {
  const std::vector<Match> matches = matchGuided(extract(room().render(0).image), extract(room().render(1).image));
  for (size_t i = 1; i < matches.size(); ++i) EXPECT_LT(matches[i - 1].reference, matches[i].reference);
  for (const Match& match : matches) EXPECT_GE(match.second_distance, match.distance);
}

TEST(GuidedSearch, IsFullWhereNothingMovesTogether) {
  const Features reference = extract(room().render(0).image), other = extract(otherRoom().render(0).image);
  EXPECT_TRUE(same(matchFully(reference, other), matchGuided(reference, other)));
}

TEST(GuidedSearch, IsFullWithFewKeypoints) {
  const Features reference = extract(room().render(0).image, 500), current = extract(room().render(1).image, 500);
  EXPECT_TRUE(same(matchFully(reference, current), matchGuided(reference, current)));
}

TEST(GuidedSearch, TakesImagesWithoutKeypoints) {
  const Features some = extract(room().render(0).image), none = extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(90)));
  EXPECT_EQ(0, none.size());
  EXPECT_TRUE(matchGuided(some, none).empty());
  EXPECT_TRUE(matchGuided(none, some).empty());
}

TEST(GuidedSearch, IsTheSameOnEveryInstructionSetAndForTwoThreads) {
  const Features reference = extract(room().render(0).image), current = extract(room().render(4).image);
  const std::vector<Match> expected = matchGuided(reference, current, {false, 1, SimdLevel::kScalar});
  for (const SimdLevel level : {SimdLevel::kScalar, SimdLevel::kAvx2, SimdLevel::kAvx512, SimdLevel::kNeon}) {
    if (!simdLevelSupported(level)) continue;
    for (const int threads : {1, 2}) {
      EXPECT_TRUE(same(expected, matchGuided(reference, current, {false, threads, level}))) << toString(level);
    }
  }
}

TEST(GuidedSearch, RefusesMutualNeighbours) { EXPECT_THROW(GuidedSearch({true}, {}), std::invalid_argument); }

/// One cell for the whole image, which stands still.
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
  const Features reference = extract(room().render(0).image), current = extract(room().render(4).image);
  const MotionPrediction prior = standstill();
  const int without = countRight(matchGuided(reference, current), reference, current, 0, 4);
  EXPECT_GE(countRight(matchGuided(reference, current, {}, &prior), reference, current, 0, 4), 0.99 * without);
}

TEST(GuidedSearch, SearchesInFullWhatIsNotWhereAPriorSays) {
  const Features reference = extract(room().render(0).image), other = extract(otherRoom().render(0).image);
  const MotionPrediction prior = standstill();
  const std::vector<Match> matches = matchGuided(reference, other, {}, &prior);
  EXPECT_EQ(static_cast<size_t>(reference.size()), matches.size());
  EXPECT_FALSE(same(matchFully(reference, other), matches));
}

/// Statuses and poses of a stream, once with each search.
class StreamOfBoth : public testing::Test {
 protected:
  StreamOfBoth() : full_(optionsOf(SearchMode::kFull)), guided_(optionsOf(SearchMode::kGuided)) {
    const Camera camera(room().intrinsics(), room().options().size);
    full_.setCamera(camera);
    guided_.setCamera(camera);
  }
  /// Status of the pair that the image ends; the same with both.
  Status see(const cv::Mat& image) {
    const Status expected = full_.process(image).status;
    const MatchResult& result = guided_.process(image);
    EXPECT_EQ(expected, result.status);
    return result.status;
  }
  static MatchFilterOptions optionsOf(SearchMode search) {
    MatchFilterOptions options;
    options.search = search;
    return options;
  }
  MatchFilter full_, guided_;
};

TEST_F(StreamOfBoth, SurvivesACut) {
  EXPECT_EQ(Status::kFirstFrame, see(room().render(0).image));
  EXPECT_EQ(Status::kOk, see(room().render(1).image));
  EXPECT_NE(Status::kOk, see(otherRoom().render(0).image));
  EXPECT_EQ(Status::kOk, see(otherRoom().render(1).image));
}

TEST_F(StreamOfBoth, SurvivesAFlash) {
  see(room().render(0).image);
  cv::Mat flash;
  room().render(1).image.convertTo(flash, CV_8U, 0.3, 170);
  see(flash);
  see(room().render(2).image);
  see(cv::Mat(room().options().size, CV_8UC1, cv::Scalar(255)));
  EXPECT_NE(Status::kOk, see(room().render(3).image));
  EXPECT_EQ(Status::kOk, see(room().render(4).image));
}

TEST_F(StreamOfBoth, SurvivesAKidnapping) {
  see(room().render(0).image);
  EXPECT_EQ(Status::kOk, see(room().render(1).image));
  constexpr int kElsewhere = 150;
  EXPECT_NE(Status::kOk, see(room().render(kElsewhere).image));
  EXPECT_EQ(Status::kOk, see(room().render(kElsewhere + 1).image));
}

}  // namespace
}  // namespace gms_ransac
