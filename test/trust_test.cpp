// What `evaluate trust` says of one answer, against values worked out by hand.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "gms_ransac/parameter.h"
#include "trust/trust_json.h"
#include "trust/trust_plan.h"
#include "trust/trust_row.h"

namespace gms_ransac {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

Matrix3d turn(double degrees, const Vector3d& axis) {
  return Eigen::AngleAxisd(degrees * kDegree, axis).toRotationMatrix();
}

/// An answer with sigmas of 0.1 degrees of rotation and 1 degree of direction along z.
RobustResult answer(const Matrix3d& R, const Vector3d& t) {
  RobustResult result;
  result.model_found = result.pose_found = result.translation_observable = true;
  result.inlier_count = 100;
  result.pose.R = R;
  result.pose.t = t;
  result.pose.covariance.topLeftCorner<3, 3>() = std::pow(kDegree, 2) * Matrix3d::Identity();
  result.pose.covariance.bottomRightCorner<3, 3>() = std::pow(0.1 * kDegree, 2) * Matrix3d::Identity();
  return result;
}

TrustRow row(Status status, const RobustResult& result, const PoseTruth& truth) {
  TrustContext context;
  context.kind = "real";
  context.status = status;
  return makeTrustRow(context, result, &truth, Reliability());
}

PoseTruth forward(double metres) {
  PoseTruth truth;
  truth.pose.translation() = Vector3d(0, 0, metres);
  truth.limits = kExactLimits;
  return truth;
}

TEST(Trust, NormalizedSquareByHand) {
  Matrix2d covariance;
  covariance << 4, 0, 0, 9;
  EXPECT_NEAR(normalizedSquare(Vector2d(2, 6), covariance), (1 + 4) / 2., 1e-12);
  EXPECT_TRUE(std::isnan(normalizedSquare(Vector2d(2, 6), Matrix2d::Zero())));
}

TEST(Trust, TangentErrorIsTheAngleAndTheCovarianceAcross) {
  const Vector3d estimate(0, 0, 1), truth(std::sin(0.2), 0, std::cos(0.2));
  const TangentError tangent = tangentError(estimate, truth, Vector3d(0.04, 0.04, 9).asDiagonal());
  EXPECT_NEAR(tangent.error.norm(), 0.2, 1e-12);
  EXPECT_NEAR((tangent.covariance - 0.04 * Matrix2d::Identity()).norm(), 0, 1e-12) << "nothing of what lies along it";
  EXPECT_NEAR(tangentError(estimate, -estimate, Matrix3d::Identity()).error.norm(), M_PI, 1e-12);
}

TEST(Trust, ErrorsAreThoseOfTheEstimateAgainstTheTruth) {
  const TrustRow r = row(
      Status::kOk, answer(turn(0.3, Vector3d::UnitY()), turn(2, Vector3d::UnitX()) * Vector3d::UnitZ()), forward(1));
  EXPECT_NEAR(r.ry_deg, 0.3, 1e-9);
  EXPECT_NEAR(r.rotation_error_deg, 0.3, 1e-9);
  EXPECT_NEAR(r.direction_error_deg, 2, 1e-9);
  EXPECT_NEAR(r.nees_rotation, 9 / 3., 1e-9);
  EXPECT_NEAR(r.nees_direction, 4 / 2., 1e-9);
  EXPECT_NEAR(r.uncertainty_deg, 0.1 + 1, 1e-9);
  EXPECT_TRUE(r.right);
  EXPECT_FALSE(r.wrong);
  EXPECT_EQ(r.covariance.size(), 36u);
}

TEST(Trust, NoiseOfTheTruthIsAddedToTheCovariance) {
  PoseTruth truth = forward(1);
  truth.noise = {0.2 * kDegree, std::sqrt(3.) * kDegree};  // over a metre: that much of the direction
  const TrustRow r =
      row(Status::kOk, answer(turn(0.3, Vector3d::UnitY()), turn(2, Vector3d::UnitX()) * Vector3d::UnitZ()), truth);
  EXPECT_NEAR(r.nees_rotation, 0.09 / (0.01 + 0.04) / 3, 1e-9);
  EXPECT_NEAR(r.nees_direction, 4 / (1 + 3.) / 2, 1e-9);
}

TEST(Trust, AClockThatIsOffMovesTheTruthOneWay) {
  PoseTruth truth = forward(1);
  truth.clock_step = {Vector3d(0, 0.2 * kDegree, 0), Vector3d(std::tan(2 * kDegree), 0, 0)};
  const Vector3d aside = turn(2, Vector3d::UnitY()) * Vector3d::UnitZ();
  const TrustRow along = row(Status::kOk, answer(turn(0.3, Vector3d::UnitY()), aside), truth);
  EXPECT_NEAR(along.nees_rotation, 0.09 / (0.01 + 0.04) / 3, 1e-9);
  EXPECT_NEAR(along.nees_direction, 4 / (1 + 4.) / 2, 1e-2);
  const TrustRow across = row(Status::kOk, answer(turn(0.3, Vector3d::UnitX()), aside), truth);
  EXPECT_NEAR(across.nees_rotation, 0.09 / 0.01 / 3, 1e-9);
}

TEST(Trust, AxesThatAreTurnedTurnTheDirectionAndLittleOfTheRotation) {
  PoseTruth truth = forward(5);
  truth.noise.alignment = 0.2 * kDegree;
  truth.pose.linear() = turn(1, Vector3d::UnitZ());
  const PairNoise noise(truth.noise, {}, truth.pose);
  EXPECT_NEAR(std::sqrt(noise.translation(0, 0)), 5 * 0.2 * kDegree, 1e-9) << "whatever the length";
  EXPECT_NEAR(noise.translation(2, 2), 0, 1e-12);
  EXPECT_NEAR(std::sqrt(noise.rotation(1, 1)), kDegree * 0.2 * kDegree, 1e-9);
  EXPECT_NEAR(noise.rotation(2, 2), 0, 1e-12);
}

TEST(Trust, WrongIsAnOkBeyondTheLimits) {
  const Matrix3d same = Matrix3d::Identity(), off = turn(1.2, Vector3d::UnitZ());
  const Vector3d ahead(0, 0, 1), aside(1, 0, 0);
  EXPECT_TRUE(row(Status::kOk, answer(off, ahead), forward(1)).wrong);
  EXPECT_TRUE(row(Status::kOk, answer(same, aside), forward(1)).wrong);
  EXPECT_FALSE(row(Status::kLowParallax, answer(same, aside), forward(1)).wrong);
  EXPECT_FALSE(row(Status::kLowParallax, answer(same, aside), forward(1)).right);
  EXPECT_TRUE(row(Status::kLowParallax, answer(same, ahead), forward(1)).right) << "refused though right";
  // A camera that is known to have stood has no direction to be OK about; one that may have, is judged by its rotation.
  EXPECT_TRUE(row(Status::kOk, answer(same, ahead), forward(0)).wrong);
  EXPECT_FALSE(row(Status::kLowParallax, answer(same, ahead), forward(0)).wrong);
  PoseTruth hardly = forward(0.01);
  hardly.noise.translation = 0.005;
  EXPECT_FALSE(row(Status::kOk, answer(same, aside), hardly).moved);
  EXPECT_FALSE(row(Status::kOk, answer(same, aside), hardly).wrong);
  EXPECT_TRUE(row(Status::kOk, answer(same, aside), hardly).direction_error_deg != 0);
}

TEST(Trust, AnswersThatWereNotGivenHaveNoFigures) {
  const TrustRow r = row(Status::kRansacFailed, RobustResult(), forward(1));
  for (const double figure : {r.rotation_error_deg, r.nees_rotation, r.rotation_sigma_deg, r.sigma_px}) {
    EXPECT_TRUE(std::isnan(figure)) << figure;
  }
  EXPECT_FALSE(r.right);
  EXPECT_TRUE(r.covariance.empty());
}

TEST(Trust, BinsHoldCountsSumsAndRightMatches) {
  Reliability reliability;
  reliability.add(0.05, false);
  reliability.add(0.95, true);
  reliability.add(1, true);
  reliability.add(0.91, false);
  EXPECT_EQ(reliability.bins[0].count, 1);
  EXPECT_EQ(reliability.bins[9].count, 3);
  EXPECT_NEAR(reliability.bins[9].probability, 2.86, 1e-12);
  EXPECT_EQ(reliability.bins[9].right, 2);
}

TEST(Trust, RowsBecomeLinesOfOneFile) {
  TrustRow answered = row(Status::kOk, answer(turn(0.3, Vector3d::UnitY()), Vector3d(0.1, 0, 1)), forward(1));
  answered.pair = "a b";
  answered.survivors = 4321;
  answered.reliability.add(0.95, true);
  const std::string csv = trustCsv({runsText({answered}), runsText({row(Status::kRansacFailed, {}, forward(1))})});
  EXPECT_EQ(csv.compare(0, 9, "kind,set,"), 0) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_NE(csv.find(",\"a b\","), std::string::npos) << csv;
  EXPECT_NE(csv.find(",4321,"), std::string::npos) << csv;
  EXPECT_NE(csv.find(" 1 0.95 1\n"), std::string::npos) << "the last bin ends the line\n" << csv;
  EXPECT_NE(csv.find(",,,,"), std::string::npos) << "what was not answered has no figures\n" << csv;
  for (const char* none : {"nan", "null"}) EXPECT_EQ(csv.find(none), std::string::npos) << csv;
}

TEST(Trust, ThePlanHoldsEveryParameterOfTheCore) {
  TrustPlan plan;
  plan.pipelines.resize(1);
  for (const Parameter& parameter : coreParameters()) {
    EXPECT_NE(planText(plan).find('"' + parameter.name + '"'), std::string::npos) << parameter.name;
  }
}

TEST(Trust, NoiseOfTheTruthFollowsTheKindOfSet) {
  EXPECT_GT(defaultTruthNoise("/data/7scenes_redkitchen/").translation, defaultTruthNoise("tum_fr1_desk").translation);
  EXPECT_EQ(defaultTruthNoise("rendered_street").rotation, 0);
  EXPECT_GT(defaultTruthNoise("my_KITTI_07").rotation, 0);
}

}  // namespace
}  // namespace gms_ransac
