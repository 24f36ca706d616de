// Motion statistics against the dense published form and against cases worked out by hand.
#include "gms_ransac/motion_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "benchmark/opencv_baseline.h"
#include "gms/cell_grid.h"

namespace gms_ransac {
namespace {

/// Two images and the matches between them.
struct MatchScene {
  Features reference, current;
  std::vector<Match> matches;

  MatchScene(cv::Size reference_size, cv::Size current_size) {
    reference.image_size = reference_size;
    current.image_size = current_size;
  }
  explicit MatchScene(cv::Size size) : MatchScene(size, size) {}

  void add(cv::Point2f from, cv::Point2f to, int times = 1) {
    for (int i = 0; i < times; ++i) {
      reference.keypoints.emplace_back(from, 31.f);
      current.keypoints.emplace_back(to, 31.f);
      matches.push_back({reference.size() - 1, current.size() - 1, 0, 257});
    }
  }
  MotionStatistics compute(const MotionStatisticsOptions& options) const {
    MotionStatisticsFilter filter(options);
    MotionStatistics statistics;
    filter.compute(reference, current, matches, statistics);
    return statistics;
  }
};

/// Centre of a cell of a 20 x 20 grid over 400 x 400 pixels.
cv::Point2f cellCenter(int column, int row) { return {20.f * column + 5.f, 20.f * row + 5.f}; }

MotionStatisticsOptions tinyThreshold() {
  MotionStatisticsOptions options;
  options.threshold_factor = 0.01;
  return options;
}

void expectEqual(const MotionStatistics& sparse, const MotionStatistics& dense) {
  EXPECT_EQ(sparse.accepted_count, dense.accepted_count);
  EXPECT_EQ(sparse.scale, dense.scale);
  EXPECT_EQ(sparse.rotation, dense.rotation);
  EXPECT_EQ(sparse.accepted, dense.accepted);
  EXPECT_EQ(sparse.score, dense.score);
  EXPECT_EQ(sparse.relative_score, dense.relative_score);
  EXPECT_EQ(sparse.cell, dense.cell);
}

class RandomScenes {
 public:
  explicit RandomScenes(unsigned seed) : random_(seed) {}

  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  float real(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  bool coin() { return integer(0, 1) == 1; }

  MotionStatisticsOptions options() {
    MotionStatisticsOptions options;
    if (integer(0, 2) == 0) {
      options.grid_columns = integer(2, 24);
      options.grid_rows = integer(2, 24);
    }
    const double factors[] = {6.0, 6.0, 4.0, 2.0, 0.5};
    options.threshold_factor = factors[integer(0, 4)];
    // A dense run with all rotations and scales costs fifty times a plain one.
    const int flags = integer(0, 15);
    options.rotation = flags == 0 || flags == 1;
    options.scale = flags == 0 || flags == 2;
    options.border = coin() ? GridBorder::kOpencv : GridBorder::kOriginal;
    options.neighborhood = coin() ? GridNeighborhood::kNine : GridNeighborhood::kFive;
    return options;
  }

  MatchScene scene() {
    MatchScene scene({integer(16, 1300), integer(16, 800)}, {integer(16, 1300), integer(16, 800)});
    const int kind = integer(0, 5);
    const int n = kind == 0 ? integer(0, 3) : integer(0, coin() ? 200 : 1500);
    const float spread = kind == 1 ? 0.f : real(0.f, 0.15f), outliers = real(0.f, 1.f);
    const float angle = kind == 2 ? real(0.f, 6.3f) : 0.f, zoom = kind == 3 ? real(0.4f, 2.2f) : 1.f;
    const cv::Point2f centre(real(0.f, 1.f), real(0.f, 1.f)), motion(real(-0.2f, 0.2f), real(-0.2f, 0.2f));
    for (int i = 0; i < n; ++i) {
      cv::Point2f p = kind <= 1 || i % 4 == 0 ? centre + cv::Point2f(real(-spread, spread), real(-spread, spread))
                                              : cv::Point2f(real(0.f, 1.f), real(0.f, 1.f));
      const cv::Point2f d = zoom * (p - cv::Point2f(0.5f, 0.5f));
      cv::Point2f q = cv::Point2f(0.5f + std::cos(angle) * d.x - std::sin(angle) * d.y,
                                  0.5f + std::sin(angle) * d.x + std::cos(angle) * d.y) +
                      motion;
      if (real(0.f, 1.f) < outliers) q = {real(0.f, 1.f), real(0.f, 1.f)};
      scene.add(pixel(p, scene.reference.image_size), pixel(q, scene.current.image_size));
    }
    return scene;
  }

 private:
  /// Clamped to the image, so that some points lie exactly on its border; some on whole pixels and cell borders.
  cv::Point2f pixel(cv::Point2f p, cv::Size size) {
    const auto width = static_cast<float>(size.width), height = static_cast<float>(size.height);
    cv::Point2f q(std::min(std::max(p.x, 0.f), 1.f) * width, std::min(std::max(p.y, 0.f), 1.f) * height);
    if (integer(0, 3) == 0) q = {std::round(q.x), std::round(q.y)};
    if (integer(0, 20) == 0) q.x = std::round(40.f * q.x / width) * width / 40.f;
    if (integer(0, 20) == 0) q.y = std::round(40.f * q.y / height) * height / 40.f;
    return q;
  }
  std::mt19937 random_;
};

TEST(MotionStatistics, EqualsTheDenseFormOnRandomScenesWhateverCameBefore) {
  constexpr int kTrials = 1500;  // a fault that shows in one of 300 scenes is missed with a probability of 0.7 %
  RandomScenes random(1);
  MotionStatistics sparse, dense;
  int accepted = 0, rotated = 0, scaled = 0;
  for (int trial = 0; trial < kTrials && !HasFailure(); ++trial) {
    const MatchScene before = random.scene(), scene = random.scene();
    const MotionStatisticsOptions options = random.options();
    SCOPED_TRACE(testing::Message() << "trial " << trial);
    MotionStatisticsFilter filter(options);
    filter.compute(before.reference, before.current, before.matches, sparse);
    filter.compute(scene.reference, scene.current, scene.matches, sparse);
    denseMotionStatistics(options, scene.reference, scene.current, scene.matches, dense);
    expectEqual(sparse, dense);
    accepted += sparse.accepted_count > 0;
    rotated += sparse.rotation > 0;
    scaled += sparse.scale > 0;
  }
  // The scenes must exercise what is compared.
  EXPECT_GT(accepted, 0.3 * kTrials);
  EXPECT_GT(rotated, 5e-3 * kTrials);
  EXPECT_GT(scaled, 5e-3 * kTrials);
}

TEST(MotionStatistics, TieGoesToTheLowestRightCell) {
  MatchScene scene({400, 400});
  scene.add(cellCenter(5, 5), cellCenter(9, 9), 3);
  scene.add(cellCenter(5, 5), cellCenter(8, 9), 3);
  scene.add(cellCenter(5, 5), cellCenter(10, 9), 3);
  const MotionStatistics statistics = scene.compute(tinyThreshold());
  EXPECT_EQ(statistics.accepted, (std::vector<uint8_t>{0, 0, 0, 1, 1, 1, 0, 0, 0}));
}

TEST(MotionStatistics, ScoreAndSupportAreThoseOfTheCellPair) {
  // Cell (5,5) holds 50 matches to (7,6); its right neighbour 30 that move alike; its left one 10 that do not.
  MatchScene scene({400, 400});
  scene.add(cellCenter(5, 5), cellCenter(7, 6), 50);
  scene.add(cellCenter(6, 5), cellCenter(8, 6), 30);
  scene.add(cellCenter(4, 5), cellCenter(15, 15), 10);
  const MotionStatistics statistics = scene.compute({});
  EXPECT_EQ(statistics.accepted_count, 80);  // the ten see 10 votes of the 50 + 10 around them
  EXPECT_EQ(statistics.score[0], 80);
  EXPECT_FLOAT_EQ(statistics.relative_score[0], static_cast<float>(80 / (6 * std::sqrt(90.0 / 9))));
  EXPECT_EQ(statistics.score[89], 0);
  EXPECT_EQ(statistics.relative_score[89], 0.f);
  EXPECT_EQ(statistics.cell[0], 5 * 20 + 5);
}

TEST(MotionStatistics, FiveCellsIgnoreTheDiagonalAndScaleTheThreshold) {
  MatchScene scene({400, 400});
  scene.add(cellCenter(5, 5), cellCenter(7, 6), 12);
  scene.add(cellCenter(5, 4), cellCenter(7, 5), 7);   // north
  scene.add(cellCenter(6, 6), cellCenter(8, 7), 40);  // diagonal: counts with nine cells only
  MotionStatisticsOptions options = tinyThreshold();
  EXPECT_EQ(scene.compute(options).score[0], 59);
  options.neighborhood = GridNeighborhood::kFive;
  EXPECT_EQ(scene.compute(options).score[0], 19);
  options.threshold_factor = 6;
  EXPECT_FLOAT_EQ(scene.compute(options).relative_score[0],
                  static_cast<float>(19 / (6 * std::sqrt(5.0 / 9) * std::sqrt(19.0 / 5))));
}

TEST(MotionStatistics, BordersDifferAsPublished) {
  // All matches start in the upper left quarter of the first cell: with the grid shifted they make a cell of their own
  // for xfeatures2d, and are dropped by the original. The score differs through the neighbours they then have.
  MatchScene scene({400, 400});
  scene.add({2.f, 2.f}, cellCenter(3, 3), 60);
  scene.add({12.f, 2.f}, cellCenter(4, 3), 50);
  MotionStatisticsOptions options = tinyThreshold();
  EXPECT_EQ(scene.compute(options).score[0], 110);  // shifted by half a cell the 50 are the right neighbours
  options.border = GridBorder::kOriginal;
  EXPECT_EQ(scene.compute(options).score[0], 60);  // only the unshifted grid, where all share the cell
}

/// Points within `reach` of the centre, `zoom` times as far from it in the reference, by quarters of a rotation.
MatchScene turnedScene(float reach, float zoom, int quarters) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> coordinate(-reach, reach);
  MatchScene scene({400, 400});
  for (int i = 0; i < 4000; ++i) {
    const cv::Point2f centre(200.f, 200.f), from(coordinate(random), coordinate(random));
    cv::Point2f to = from;
    for (int k = 0; k < quarters; ++k) to = {to.y, -to.x};  // anticlockwise as seen in the image (y down)
    scene.add(centre + zoom * from, centre + to);
  }
  return scene;
}

TEST(MotionStatistics, FindsRotationAndScale) {
  MotionStatisticsOptions options;
  options.rotation = true;
  for (const auto neighborhood : {GridNeighborhood::kNine, GridNeighborhood::kFive}) {
    options.neighborhood = neighborhood;
    for (int quarters = 0; quarters < 4; ++quarters) {
      const MotionStatistics statistics = turnedScene(140, 1, quarters).compute(options);
      EXPECT_EQ(statistics.rotation, 2 * quarters);
      EXPECT_GT(statistics.accepted_count, 2000);
    }
  }
  options = {};
  options.scale = true;
  const MotionStatistics halved = turnedScene(80, 2, 0).compute(options);
  EXPECT_EQ(halved.scale, 4);  // right grid of twice the cells
  EXPECT_GT(halved.accepted_count, 3500);
}

TEST(MotionStatistics, PointsThatAreNoNumbersAreLeftOut) {
  MatchScene scene({400, 400});
  const float nan = std::numeric_limits<float>::quiet_NaN(), huge = 1e30f;
  scene.add({nan, 5.f}, {5.f, 5.f});
  scene.add({5.f, 5.f}, {nan, nan});
  scene.add({-huge, huge}, {huge, -huge});
  EXPECT_EQ(scene.compute(tinyThreshold()).accepted_count, 0);
}

/// 40 matches from cell to cell in either of two neighbouring cells, with a second distance of 80.
MatchScene alikeMatches() {
  MatchScene scene({400, 400});
  scene.add(cellCenter(5, 5), cellCenter(7, 6), 40);
  scene.add(cellCenter(6, 5), cellCenter(8, 6), 40);
  for (Match& match : scene.matches) match.second_distance = 80;
  return scene;
}

MotionStatisticsOptions evidence() {
  MotionStatisticsOptions options;
  options.criterion = Criterion::kEvidence;
  options.grid_columns = options.grid_rows = 20;
  return options;
}

TEST(MotionStatistics, EvidenceDropsWhatTurnsOtherwiseAndOrdersByDescriptors) {
  MatchScene scene = alikeMatches();
  for (int i = 0; i < 80; ++i) {
    scene.reference.keypoints[i].angle = 10.f;
    scene.current.keypoints[i].angle = i == 3 ? 200.f : 15.f;  // one rotates by 190 degrees instead of 5
    scene.matches[i].distance = i == 4 ? 20 : 40;
  }
  scene.matches[5].second_distance = 41;
  const MotionStatistics statistics = scene.compute(evidence());
  EXPECT_EQ(statistics.accepted_count, 79);
  EXPECT_EQ(statistics.accepted[3], 0);
  EXPECT_EQ(statistics.score[3], 0);
  EXPECT_EQ(statistics.score[0], 79);  // the rotated one did not vote either
  EXPECT_EQ(statistics.relative_score[0], statistics.relative_score[5]);
  EXPECT_GT(statistics.log_odds[0], statistics.log_odds[5]);  // ambiguous descriptor
  EXPECT_GT(statistics.log_odds[4], statistics.log_odds[0]);  // closer descriptor
}

TEST(MotionStatistics, EvidenceFollowsARollingCamera) {
  MatchScene scene = alikeMatches();
  for (int i = 0; i < 80; ++i) {
    scene.reference.keypoints[i].angle = static_cast<float>(4 * i);
    scene.current.keypoints[i].angle = static_cast<float>((4 * i + 357) % 360);  // back by three degrees, through zero
  }
  EXPECT_EQ(scene.compute(evidence()).accepted_count, 80);
}

TEST(MotionStatisticsSettings, FollowTheCriterionWhereTheyAreOpen) {
  const MotionStatisticsOptions paper = withDefaults({}), ours = withDefaults({}, Criterion::kEvidence);
  EXPECT_EQ(paper.criterion, Criterion::kThreshold);
  EXPECT_EQ(paper.grid_columns, 20);
  EXPECT_EQ(paper.grid_rows, 20);
  EXPECT_EQ(paper.threshold_factor, 6);
  EXPECT_EQ(ours.criterion, Criterion::kEvidence);
  EXPECT_EQ(ours.grid_columns, std::nullopt);
  EXPECT_EQ(ours.threshold_factor, 1);
  MotionStatisticsOptions given;
  given.grid_columns = 30;
  given.threshold_factor = 5;
  given.criterion = Criterion::kThreshold;
  const MotionStatisticsOptions kept = withDefaults(given, Criterion::kEvidence);
  EXPECT_EQ(kept.grid_columns, 30);
  EXPECT_EQ(kept.threshold_factor, 5);
  EXPECT_EQ(kept.criterion, Criterion::kThreshold);
}

TEST(MotionStatisticsSettings, AutomaticGridHasSquareCellsFewForFewMatches) {
  MotionStatisticsOptions options;
  const CellGrid kitti = chooseGrid(options, {1241, 376}, 5000), few = chooseGrid(options, {1241, 376}, 300);
  EXPECT_NEAR(1241.0 / kitti.columns, 376.0 / kitti.rows, 2.0);
  EXPECT_NEAR(kitti.columns * kitti.rows, 400, 20);
  EXPECT_LT(few.columns * few.rows, 100);
  const CellGrid none = chooseGrid(options, {640, 480}, 0), no_image = chooseGrid(options, {0, 0}, 100);
  EXPECT_GE(std::min(none.columns, none.rows), 2);
  EXPECT_GE(std::min(no_image.columns, no_image.rows), 2);
  options.grid_columns = 32;
  EXPECT_EQ(chooseGrid(options, {640, 480}, 2000).rows, 24);
}

TEST(MotionStatisticsOptions, RefusesWhatIsOutOfRange) {
  MotionStatisticsOptions options;
  options.grid_columns = 1;
  EXPECT_THROW(options.validate(), std::invalid_argument);
  options.grid_columns = 101;
  EXPECT_THROW(options.validate(), std::invalid_argument);
  options.grid_columns.reset();
  EXPECT_NO_THROW(options.validate());
  options.threshold_factor = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(MotionStatisticsFilter{options}, std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
