// ~rolling_shutter_readout on drawn and rendered scenes of exact truth: what it takes away, and that a wrong readout or
// a wrong gyro adds nothing.
#include "methods/rolling_shutter.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "percentile.h"
#include "rendered_scene.h"
#include "scenes/drawn_scenes.h"
#include "two_view/pose_model.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

using Eigen::Vector3d;

constexpr int kPairs = 40;
constexpr double kReadout = 0.9 * kSceneInterval;  // of the drawn scenes
constexpr double kGyroSigma = 0.01;                // rad/s

const DrawnScene& sceneOf(const std::string& name) {
  for (const DrawnScene& scene : drawnScenes()) {
    if (scene.name == name) return scene;
  }
  throw std::invalid_argument(name);
}

RobustOptions withReadout(double seconds) {
  RobustOptions options;
  options.rolling_shutter_readout = seconds;
  return options;
}

/// Answers to the pairs of a drawn scene, whose camera goes a straight way.
struct Answers {
  std::vector<double> rotation, direction;  ///< errors, degrees
  int ok = 0, rows_contradicted = 0;
  int corrected[5] = {};  ///< by RowCorrection

  int by(RowCorrection correction) const { return corrected[static_cast<size_t>(correction)]; }
};

template <class Change>
Answers answers(const std::string& method, const std::string& scene, double readout, const Change& change) {
  Answers all;
  const auto estimator = makeEstimator(method, withReadout(readout));
  RobustResult result;
  for (int i = 0; i < kPairs; ++i) {
    Random random(static_cast<uint64_t>(i) + 1);
    TwoViewSceneOptions options = sceneOf(scene).options(random);
    options.straight = true;
    options.seed = random.next();
    TwoViewScene pair = makeTwoViewScene(options);
    change(pair, i);
    estimator->estimate(pair.pairs, pair.camera, result);
    const PoseErrors errors = result.judgement.pose_found ? poseErrors(result, pair) : PoseErrors{180, 180};
    all.rotation.push_back(errors.rotation);
    all.direction.push_back(errors.direction);
    all.ok += statusOf(result, pair.camera) == Status::kOk;
    all.rows_contradicted +=
        result.judgement.camera_misfit > 1 && result.judgement.misfit_parameter == CameraParameter::kRollingShutter;
    ++all.corrected[static_cast<size_t>(result.row_correction)];
  }
  return all;
}

Answers answers(const std::string& method, const std::string& scene, double readout) {
  return answers(method, scene, readout, [](TwoViewScene&, int) {});
}

/// The rotation that a gyro measures for a pair of a scene whose camera has 1 - acceleration of its speed at the
/// reference and 1 + acceleration at the current image.
RotationPrior gyroOf(const TwoViewScene& scene, double acceleration, int seed) {
  Random random(static_cast<uint64_t>(seed) + 1);
  const auto noise = [&] {
    Vector3d v;
    for (int k = 0; k < 3; ++k) v[k] = kGyroSigma * gaussian(random);
    return v;
  };
  const Eigen::AngleAxisd rotation(Eigen::Matrix3d(scene.R.transpose()));
  const Vector3d rate = rotation.angle() / kSceneInterval * rotation.axis();
  RotationPrior prior;
  prior.R = rotationFromVector(kSceneInterval * noise()) * rotation.toRotationMatrix();
  prior.covariance.diagonal().setConstant(kGyroSigma * kSceneInterval * kGyroSigma * kSceneInterval);
  prior.rates = RotationRates{(1 - acceleration) * rate + noise(), (1 + acceleration) * rate + noise()};
  return prior;
}

TEST(RollingShutter, MovesPointsToWhereTheMiddleRowWouldHaveSeenThem) {
  TwoViewSceneOptions options;
  options.noise_px = options.outlier_ratio = 0;
  options.translation.setZero();
  options.readout = 0.6;
  const TwoViewScene scene = makeTwoViewScene(options);
  const Vector3d rate = -options.rotation / kSceneInterval;
  PointPairs moved;
  moveToMiddleRow(scene.pairs, scene.camera, options.readout * kSceneInterval, {rate, rate}, moved);
  const Eigen::Matrix3d K = scene.camera.K(), H = K * scene.R * K.inverse();
  const auto farthest = [&](const PointPairs& pairs) {
    double most = 0;
    for (size_t i = 0; i < pairs.x_reference.size(); ++i) {
      const Eigen::Vector2d seen(pairs.x_current[i], pairs.y_current[i]);
      const Vector3d from(pairs.x_reference[i], pairs.y_reference[i], 1);
      most = std::max(most, ((H * from).hnormalized() - seen).norm());
    }
    return most;
  };
  EXPECT_GT(farthest(scene.pairs), 1);
  EXPECT_LT(farthest(moved), 0.01);
}

TEST(RollingShutter, TakesTheRowsOfTheImageAsItCame) {
  TwoViewSceneOptions options;
  options.matches = 10;
  TwoViewScene scene = makeTwoViewScene(options);
  const RotationRates rates = {{0, 1, 0}, {0, 1, 0}};
  scene.pairs.row_reference.assign(10, 239.5f);  // the middle one
  scene.pairs.row_current.assign(10, 0.f);
  PointPairs moved;
  moveToMiddleRow(scene.pairs, scene.camera, 0.02, rates, moved);
  for (size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(moved.x_reference[i], scene.pairs.x_reference[i], 1e-3);
    EXPECT_LT(moved.x_current[i], scene.pairs.x_current[i] - 4);  // a hundredth of a radian before
  }
}

class Methods : public testing::TestWithParam<const char*> {};

TEST_P(Methods, RotateAndDriveWithAFractionOfTheError) {
  for (const std::string scene : {"rolling_turning", "rolling_straight"}) {
    const Answers without = answers(GetParam(), scene, 0), with = answers(GetParam(), scene, kReadout);
    EXPECT_EQ(without.by(RowCorrection::kNone), kPairs);
    EXPECT_GE(with.by(RowCorrection::kPair), kPairs * 9 / 10) << scene;
    EXPECT_LT(3 * median(with.rotation), median(without.rotation)) << scene;
    EXPECT_GE(with.ok, without.ok) << scene;
    EXPECT_LT(with.rows_contradicted, kPairs / 10) << scene;
    if (scene == "rolling_turning") continue;
    EXPECT_LT(2 * median(with.direction), median(without.direction));
    EXPECT_GT(without.rows_contradicted, kPairs / 3);
    EXPECT_EQ(with.ok, kPairs);
  }
}

TEST_P(Methods, ReadUnevenRotationsFromAGyro) {
  const auto gyro = [](TwoViewScene& pair, int i) { pair.pairs.rotation_prior = gyroOf(pair, 0.5, i); };
  const std::string scene = "rolling_driving_faster";
  const Answers without = answers(GetParam(), scene, 0), with = answers(GetParam(), scene, kReadout, gyro);
  EXPECT_GE(with.by(RowCorrection::kPrior), kPairs * 9 / 10);
  EXPECT_LT(4 * median(with.rotation), median(without.rotation));
  EXPECT_LT(4 * median(with.direction), median(without.direction));
  EXPECT_LT(without.ok, kPairs * 3 / 4);
  EXPECT_GE(with.ok, kPairs * 9 / 10);
}

TEST_P(Methods, FollowAChangeOfTheRotationWithAReadoutThatWasLearnt) {
  const auto learnt = [](bool stood_before, double deviation) {
    return [=](TwoViewScene& pair, int) {
      const double focal_lengths = pair.camera.pinhole().fy / pair.camera.imageSize().height;
      pair.pairs.shutter = {Shutter::kRolling, kReadout * focal_lengths, deviation};
      // A camera that begins to rotate: half of the mean rate at the reference, one and a half at the current image.
      if (stood_before) pair.pairs.velocity_before = AngularVelocity{Vector3d::Zero(), 1e-4};
    };
  };
  const std::string scene = "rolling_driving_faster";
  const Answers unknown = answers(GetParam(), scene, -1), even = answers(GetParam(), scene, -1, learnt(false, 1e-3)),
                followed = answers(GetParam(), scene, -1, learnt(true, 1e-3)),
                unsure = answers(GetParam(), scene, -1, learnt(true, kReadout));
  EXPECT_GE(followed.by(RowCorrection::kPair), kPairs * 9 / 10);
  EXPECT_LT(3 * median(followed.rotation), median(even.rotation));
  EXPECT_LT(3 * median(followed.direction), median(even.direction));
  EXPECT_EQ(unsure.rotation, unknown.rotation) << "known to its own size";
}

TEST_P(Methods, AreNoWorseForAWrongGyro) {
  const auto wrong = [](int kind) {
    return [kind](TwoViewScene& pair, int i) {
      RotationPrior prior = gyroOf(pair, 0, i);
      const auto spoil = [&](const Vector3d& v) {
        return kind == 0 ? Vector3d(v.x(), -v.y(), v.z()) : kind == 1 ? Vector3d(v.z(), v.x(), v.y()) : Vector3d(-v);
      };
      const Eigen::AngleAxisd rotation(prior.R);
      prior.R = rotationFromVector(spoil(rotation.angle() * rotation.axis()));
      prior.rates = RotationRates{spoil(prior.rates->reference), spoil(prior.rates->current)};
      pair.pairs.rotation_prior = prior;
    };
  };
  for (const std::string scene : {"rolling_turning", "rolling_straight", "rotation_noise_0.3"}) {
    const Answers none = answers(GetParam(), scene, kReadout);
    for (int kind = 0; kind < 3; ++kind) {
      const Answers spoilt = answers(GetParam(), scene, kReadout, wrong(kind));
      for (size_t i = 0; i < kPairs; ++i) {
        EXPECT_LT(spoilt.rotation[i], none.rotation[i] + 0.02) << scene << ' ' << kind << ' ' << i;
      }
      EXPECT_LT(median(spoilt.rotation), 1.1 * median(none.rotation)) << scene << ' ' << kind;
      EXPECT_GE(spoilt.ok + 1, none.ok) << scene << ' ' << kind;
    }
  }
}

TEST_P(Methods, RefuseAReadoutThatIsNotTheCameras) {
  for (const std::string scene : {"general", "rotation_noise_0.3", "forward"}) {
    const Answers without = answers(GetParam(), scene, 0), with = answers(GetParam(), scene, kReadout);
    EXPECT_LT(median(with.rotation), 1.1 * median(without.rotation) + 0.005) << scene;
    EXPECT_GE(with.ok + 1, without.ok) << scene;
  }
}

TEST_P(Methods, LeaveAPairOfUnknownTimeAsItIs) {
  const auto forget = [](TwoViewScene& pair, int) { pair.pairs.seconds.reset(); };
  const Answers off = answers(GetParam(), "rolling_straight", 0);
  const Answers unknown = answers(GetParam(), "rolling_straight", kReadout, forget);
  EXPECT_EQ(unknown.by(RowCorrection::kUnknownTime), kPairs);
  EXPECT_EQ(unknown.rotation, off.rotation);
  EXPECT_EQ(unknown.direction, off.direction);
  const Answers too_close = answers(GetParam(), "rolling_straight", 2 * kSceneInterval);
  EXPECT_EQ(too_close.by(RowCorrection::kUnknownTime), kPairs) << "no camera reads two images at once";
}

INSTANTIATE_TEST_SUITE_P(RollingShutter, Methods, testing::Values("lo_prosac", "cp_ransac"));

TEST(RollingShutter, IsUndoneInTheWholeLine) {
  SceneOptions scene_options;
  scene_options.readout = 0.9;
  scene_options.turn = 2;
  scene_options.step = 0;
  const Scene scene(scene_options);
  constexpr int kGap = 5;
  MatchFilterOptions options;
  MatchFilter off(options);
  options.robust = withReadout(scene_options.readout / scene_options.rate);
  MatchFilter given(options);
  std::vector<double> without, with;
  for (int i = 0; i < 60; i += 10) {
    const RenderedFrame first = scene.render(i), second = scene.render(i + kGap);
    const auto answer = [&](MatchFilter& filter, bool stamped, RowCorrection correction) {
      const auto stamp = [&](double seconds) { return stamped ? std::optional<double>(seconds) : std::nullopt; };
      filter.setCamera(Camera(scene.intrinsics(), scene_options.size));
      filter.reset();
      filter.process(first.image, cv::Mat(), stamp(first.stamp));
      const RobustResult& result = filter.process(second.image, cv::Mat(), stamp(second.stamp)).robust;
      EXPECT_EQ(result.row_correction, correction);
      return rotationError(result.judgement.pose.R, trueRelativePose(scene, i, i + kGap).R);
    };
    answer(given, false, RowCorrection::kUnknownTime);
    without.push_back(answer(off, true, RowCorrection::kNone));
    with.push_back(answer(given, true, RowCorrection::kPair));
  }
  EXPECT_LT(median(with), median(without));
}

}  // namespace
}  // namespace gms_ransac
