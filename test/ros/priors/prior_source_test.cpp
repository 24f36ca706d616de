// The answers that sources of priors remember and report.
#include "priors/prior_source.h"

#include <map>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

/// Gives the answer that the test sets.
struct StubRotation : RotationSource {
  StubRotation() : RotationSource("/imu", 0) {}
  RotationAnswer measure(const PriorQuery& /*query*/) override { return answer; }
  RotationAnswer answer;
};

struct StubLength : LengthSource {
  LengthAnswer measure(const PriorQuery& /*query*/, const PairSeen& /*pair*/) override { return {{}, problem}; }
  std::string problem;
};

PriorQuery query(double from, double to) { return {"camera", from, to, 0.02}; }

TEST(PriorSource, ReportsWhatTheLastRotationLacks) {
  StubRotation source;
  source.answer.problem = "no message has come";
  EXPECT_EQ(source.ask(query(1, 2)).problem, "no rotation prior: no message has come");
  EXPECT_EQ(source.report().summary, "no rotation prior: no message has come");
  EXPECT_TRUE(source.report().doubtful);
  source.answer.prior = RotationPrior();
  EXPECT_EQ(source.ask(query(1, 2)).problem, "no rotation during the readout: no message has come");
  source.answer.problem.clear();
  EXPECT_EQ(source.ask(query(2, 2)).problem, "no rotation prior: the reference is not before the current image");
  EXPECT_EQ(source.ask(query(1, 2)).problem, "");
  EXPECT_FALSE(source.report().doubtful);
}

TEST(PriorSource, ComparesItsRotationsWithTheImages) {
  StubRotation source;
  source.answer.prior = RotationPrior();
  source.answer.prior->covariance = Eigen::Matrix3d::Identity();
  RobustResult seen;
  seen.judgement.pose.covariance.setIdentity();
  seen.row_correction = RowCorrection::kPrior;
  for (int i = 0; i < 3; ++i) source.compare(source.ask(query(i, i + 1)), seen);
  const PriorReport report = source.report();
  const std::map<std::string, std::string> values(report.values.begin(), report.values.end());
  EXPECT_EQ(values.at("pairs compared"), "3");
  EXPECT_EQ(values.at("pairs corrected for readout"), "3");
  EXPECT_EQ(values.at("contradicting"), "0 %");
  EXPECT_NE(report.summary.find("too few pairs to judge"), std::string::npos) << report.summary;
}

TEST(PriorSource, ReportsWhyTheLastPairHasNoLength) {
  StubLength source;
  const RobustResult result;
  const Triangulation points;
  const Camera camera;
  const PairSeen pair = {result, points, camera, {}};
  EXPECT_FALSE(source.report().doubtful);
  source.problem = "the wheels slip";
  EXPECT_EQ(source.ask(query(1, 2), pair).problem, "the wheels slip");
  EXPECT_EQ(source.report().summary, "no length: the wheels slip");
  EXPECT_TRUE(source.report().doubtful);
  source.problem.clear();
  source.ask(query(2, 3), pair);
  EXPECT_FALSE(source.report().doubtful);
}

}  // namespace
}  // namespace gms_ransac
