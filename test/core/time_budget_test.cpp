// ~max_milliseconds on simulated machines: each has its own costs and stalls.
#include "support/time_budget.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gms_ransac/match_filter.h"
#include "match_filter_hooks.h"
#include "methods/method.h"
#include "rendered_scene.h"

namespace gms_ransac {
namespace {

const cv::Size kImageSize(640, 480);

/// A machine in seconds: what a 640x480 image takes without features, and what its features add.
struct Machine {
  double image = 0.8e-3, feature = 0.25e-6, pair = 0.16e-9, filter = 0.1e-6, estimate = 0.25e-6, search = 0.02e-3;
  double stutter = 0.05;  ///< standard deviation of the logarithm of a stage's time
  double stalls = 0;      ///< share of the images during which other programs have the processor for `stall`
  double stall = 20e-3;
};

/// A stream of images on a machine under a budget.
class Stream {
 public:
  Stream(double budget, int features, const Machine& machine)
      : machine_(machine), budget_(budget, features, [this] { return now_; }) {}

  /// Seconds that the next image takes.
  double next() {
    const int asked = budget_.features(kImageSize);
    PairCost cost;
    cost.pixels = kImageSize.area();
    cost.asked = asked;
    cost.reference = asked_;
    cost.current = asked;
    cost.extract = spend(machine_.image + machine_.feature * asked);
    cost.match = spend(machine_.pair * asked * asked_);
    cost.filter = spend(machine_.filter * asked);
    if (std::uniform_real_distribution<double>()(random_) < machine_.stalls) cost.filter += spend(machine_.stall);
    budget_.limitSearch(cost.extract + cost.match + cost.filter, asked);
    const double begin = now_;
    while (now_ - begin < machine_.search && now_ < budget_.limit().search_until) now_ += 5e-6;
    cost.search = now_ - begin;
    cost.estimate = spend(machine_.estimate * asked);
    budget_.record(cost);
    asked_ = asked;
    return cost.extract + cost.match + cost.filter + cost.search + cost.estimate;
  }
  /// Share of the next images that are late.
  double late(int images, double limit) {
    int count = 0;
    for (int i = 0; i < images; ++i) count += next() > limit;
    return static_cast<double>(count) / images;
  }
  int asked() const { return asked_; }
  Machine& machine() { return machine_; }

 private:
  double spend(double seconds) {
    seconds *= std::exp(machine_.stutter * noise_(random_));
    now_ += seconds;
    return seconds;
  }

  Machine machine_;
  double now_ = 10;
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_;
  TimeBudget budget_;
  int asked_ = 0;
};

TEST(TimeBudget, IsKeptByNinetyNineOfAHundredImagesOnAnyMachine) {
  for (const double speed : {0.3, 1.0, 3.0, 10.0}) {
    for (const double stutter : {0.0, 0.05, 0.2}) {
      Machine machine;
      for (double* cost : {&machine.image, &machine.feature, &machine.pair, &machine.filter, &machine.estimate}) {
        *cost *= speed;
      }
      machine.stutter = stutter;
      const double limit = speed * 2e-3;
      Stream run(limit, 5000, machine);
      run.late(300, limit);
      EXPECT_LE(run.late(2000, limit), 0.015) << speed << " " << stutter;
      EXPECT_GT(run.asked(), 1.5 * TimeBudget::kFewest) << speed << " " << stutter;
    }
  }
}

TEST(TimeBudget, TakesNothingWhereThereIsTimeEnough) {
  Stream run(20e-3, 2000, Machine());
  run.late(30, 1);
  EXPECT_EQ(run.asked(), 2000);
}

TEST(TimeBudget, UsesMostOfTheTime) {
  Machine machine;
  machine.stutter = 0.02;
  Stream run(2e-3, 5000, machine);
  run.late(300, 1);
  double sum = 0;
  for (int i = 0; i < 100; ++i) sum += run.next();
  EXPECT_GT(sum / 100, 0.75 * 2e-3);
}

TEST(TimeBudget, FollowsAMachineThatBecomesSlowerAndFasterAgain) {
  Stream run(2.5e-3, 2000, Machine());
  run.late(100, 1);
  const int before = run.asked();
  run.machine().image = 1.4e-3;
  run.late(100, 1);
  EXPECT_LT(run.asked(), before);
  EXPECT_LE(run.late(300, 2.5e-3), 0.02);
  run.machine().image = Machine().image;
  run.late(400, 1);
  EXPECT_GE(run.asked(), 0.9 * before);
}

TEST(TimeBudget, BeginsWithFewFeaturesAndKeepsThemWhereTheImageAloneTakesTooLong) {
  Stream run(0.5e-3, 2000, Machine());
  run.next();
  EXPECT_EQ(run.asked(), TimeBudget::kFewest);
  run.late(100, 1);
  EXPECT_EQ(run.asked(), TimeBudget::kFewest);
  Stream modest(0.5e-3, 100, Machine());
  modest.late(10, 1);
  EXPECT_EQ(modest.asked(), 100);
}

TEST(TimeBudget, TakesNothingFromTheOthersForStallsThatNoCutMakesUpFor) {
  Machine stalling;
  stalling.stalls = 0.35;
  Stream stream(4e-3, 2000, stalling);
  stream.late(300, 1);
  EXPECT_EQ(stream.asked(), 2000);
  EXPECT_LE(stream.late(300, 4e-3), 0.45);
}

TEST(TimeBudget, EndsALongSearchInTimeAndAsksForNoFewerFeaturesForIt) {
  Machine hard;
  hard.stutter = 0;
  Stream easy_run(3e-3, 2000, hard);
  easy_run.late(200, 1);
  hard.search = 1;
  Stream hard_run(3e-3, 2000, hard);
  hard_run.late(200, 1);
  EXPECT_EQ(hard_run.late(100, 3.0e-3), 0);
  EXPECT_GT(hard_run.asked(), 0.7 * easy_run.asked());
}

/// A filter on a clock of the test's.
struct TimedFilter {
  double now = 10;
  double step = 0;  ///< by which every look at the clock advances it
  MatchFilter filter;

  explicit TimedFilter(double max_milliseconds, const std::string& method = "lo_prosac")
      : filter([&] {
          MatchFilterOptions options;
          options.max_milliseconds = max_milliseconds;
          options.method = method;
          return options;
        }()) {
    MatchFilterHooks::setClock(filter, [this] { return now += step; });
    filter.setCamera(cameraOf(renderedScene()));
  }
  const MatchResult& process(int frame) { return filter.process(renderedFrame(frame).image); }
};

TEST(TimeBudget, OfNoneNothingDependsOnTheClock) {
  TimedFilter standing(0), racing(0);
  racing.step = 1;
  for (int frame = 0; frame < 2; ++frame) {
    const MatchResult &a = standing.process(frame), &b = racing.process(frame);
    EXPECT_EQ(a.keypoints_current, 2000);
    EXPECT_EQ(b.keypoints_current, 2000);
    EXPECT_EQ(a.inliers, b.inliers);
    EXPECT_EQ(a.robust.judgement.pose.R, b.robust.judgement.pose.R);
    EXPECT_FALSE(b.robust.effort.search_cut || b.robust.effort.refinement_cut);
  }
}

TEST(TimeBudget, RaisesTheFeaturesOfAFilterThatHasTime) {
  TimedFilter timed(10);
  timed.step = 1e-6;
  timed.process(0);
  EXPECT_LE(timed.process(1).keypoints_current, TimeBudget::kFewest);
  for (int frame = 2; frame < 5; ++frame) timed.process(frame);
  const MatchResult& result = timed.process(5);
  EXPECT_GT(result.keypoints_current, TimeBudget::kFewest);
  EXPECT_EQ(result.status, Status::kOk);
  EXPECT_FALSE(result.robust.effort.search_cut || result.robust.effort.refinement_cut);
}

TEST(TimeBudget, CutsTheSearchOfEveryMethodAndStillAnswers) {
  for (const MethodEntry& method : methods()) {
    TimedFilter timed(1, method.name);
    timed.step = 1;  // every reading of the clock is late
    timed.process(0);
    const MatchResult& result = timed.process(1);
    EXPECT_TRUE(result.status == Status::kOk || result.status == Status::kLowParallax) << method.name;
    EXPECT_TRUE(result.robust.effort.refinement_cut) << method.name;
    // Few samples suffice here; methods that would draw more must stop.
    EXPECT_LE(result.robust.effort.hypotheses, 8 * MatchFilterOptions().robust.subset_count) << method.name;
  }
}

TEST(TimeBudget, BeginsAnewWithAnEstimateThatIsAskedForByItself) {
  TimedFilter unlimited(0), timed(50);
  Frame reference, current;
  unlimited.filter.extract(renderedFrame(0).image, reference);
  unlimited.filter.extract(renderedFrame(1).image, current);
  MatchResult expected;
  unlimited.filter.filter(reference, current, expected);
  MatchResult result = expected;
  result.times = StageTimes();
  MatchFilterHooks::estimate(timed.filter, reference, current, result);
  EXPECT_FALSE(result.robust.effort.search_cut || result.robust.effort.refinement_cut);
  EXPECT_EQ(result.robust.effort.hypotheses, expected.robust.effort.hypotheses);
  EXPECT_EQ(result.robust.judgement.pose.R, expected.robust.judgement.pose.R);

  timed.now += 1;  // later than that estimate was allowed to last
  MatchFilterHooks::estimate(timed.filter, reference, current, result);
  EXPECT_FALSE(result.robust.effort.search_cut || result.robust.effort.refinement_cut);
}

}  // namespace
}  // namespace gms_ransac
