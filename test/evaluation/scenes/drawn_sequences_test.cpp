// Drawn sequences: what their names say, and that the pipeline finds their motion where little hinders it.
#include "scenes/drawn_sequences.h"

#include <algorithm>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "gms_ransac/match_filter.h"
#include "run/truth.h"
#include "scenes/two_view_scene.h"

namespace gms_ransac {
namespace {

const DrawnSequence& named(const std::string& name) {
  const auto& all = drawnSequences();
  return *std::find_if(all.begin(), all.end(), [&](const DrawnSequence& one) { return one.name == name; });
}

double shareOfBody(const DrawnImage& image) {
  const auto count = std::count(image.on_body.begin(), image.on_body.end(), 1);
  return static_cast<double>(count) / static_cast<double>(image.on_body.size());
}

double step(const std::vector<DrawnImage>& images, size_t image) {
  return (images[image - 1].pose.inverse() * images[image].pose).translation().norm();
}

TEST(DrawnSequences, NamesAreUniqueAndSequencesRepeat) {
  std::set<std::string> names;
  for (const DrawnSequence& sequence : drawnSequences()) {
    EXPECT_TRUE(names.insert(sequence.name).second) << sequence.name;
    EXPECT_FALSE(sequence.summary.empty());
  }
  const DrawnSequence& hand = named("sequence_hand_crossing_20");
  const auto first = drawSequence(hand, 3), again = drawSequence(hand, 3), other = drawSequence(hand, 4);
  ASSERT_EQ(first.size(), static_cast<size_t>(kSequenceImages));
  const auto bytes = [](const DrawnImage& image) {
    const cv::Mat rows = image.features.descriptors.asMat();
    return std::vector<uint8_t>(rows.begin<uint8_t>(), rows.end<uint8_t>());
  };
  EXPECT_EQ(bytes(first.back()), bytes(again.back()));
  EXPECT_NE(bytes(first.back()), bytes(other.back()));
  EXPECT_NO_THROW(first.back().features.validate());
}

TEST(DrawnSequences, AreWhatTheirNamesSay) {
  for (const double percent : {10, 40}) {
    const std::string share = std::to_string(static_cast<int>(percent));
    EXPECT_NEAR(shareOfBody(drawSequence(named("sequence_driving_crossing_" + share), 0)[5]), percent / 100,
                0.003 * percent);
    EXPECT_NEAR(shareOfBody(drawSequence(named("sequence_hand_towards_" + share), 0)[9]), percent / 100,
                0.003 * percent);
  }
  const auto towards = drawSequence(named("sequence_standing_towards_40"), 0);
  EXPECT_LT(shareOfBody(towards.front()), shareOfBody(towards.back()));
  EXPECT_TRUE(towards.back().pose.isApprox(Eigen::Isometry3d::Identity()));
  const auto driving = drawSequence(named("sequence_driving_crossing_10"), 0);
  const auto braking = drawSequence(named("sequence_braking_crossing_10"), 0);
  EXPECT_NEAR(step(driving, 1), step(driving, 9), 1e-9);
  EXPECT_GT(step(braking, 1), step(braking, 4));
  EXPECT_NEAR(step(braking, 9), 0, 1e-9);
}

/// Answers with status OK to the first sequences of that name, and those of them that are wrong.
struct Count {
  int ok = 0, wrong = 0;
};
Count answersTo(const std::string& name, int sequences) {
  MatchFilter filter;
  filter.setCamera(sceneCamera());
  MatchResult result;
  Count count;
  for (int index = 0; index < sequences; ++index) {
    Past past;
    const auto images = drawSequence(named(name), index);
    for (size_t i = 1; i < images.size(); ++i) {
      filter.filter(Frame(images[i - 1].features), Frame(images[i].features), result, nullptr, &past);
      if (result.status != Status::kOk) continue;
      const PoseError error = poseError(images[i - 1].pose.inverse() * images[i].pose, result.robust.judgement.pose.R,
                                        result.robust.judgement.pose.t);
      ++count.ok;
      count.wrong += error.rotation > 1 || error.direction > 20;
    }
  }
  return count;
}

TEST(DrawnSequences, ShowTheMotionOfTheCamera) {
  const Count answers = answersTo("sequence_driving_crossing_10", 2);
  EXPECT_EQ(answers.ok, 2 * (kSequenceImages - 1));
  EXPECT_EQ(answers.wrong, 0);
}

// Without the rule on a view that contradicts itself 4 of 42 and 36 of 36 are wrong.
TEST(DrawnSequences, ABodyThatTearsTheViewIsSeldomFollowed) {
  const Count driving = answersTo("sequence_driving_crossing_40", 6), hand = answersTo("sequence_hand_crossing_40", 6);
  EXPECT_GE(driving.ok, 30);
  EXPECT_LE(driving.wrong, 2);
  EXPECT_LE(hand.wrong, 18);
}

}  // namespace
}  // namespace gms_ransac
