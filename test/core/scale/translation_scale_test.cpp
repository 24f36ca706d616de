// Triangulation and the length of the translation: on exact points, on the rendered scene, and on real sequences
// through the whole pipeline.
#include "scale/depth_pose.h"

#include <algorithm>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "datasets/dataset.h"
#include "frame_pairs.h"
#include "percentile.h"
#include "rendered_scene.h"
#include "shared_data.h"
#include "two_view/pose_model.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

/// A camera that moved, points it saw, and the answer the pipeline would give without noise.
struct ExactPair {
  Camera camera;
  Features reference, current;
  MatchResult result;
  std::vector<Eigen::Vector3d> truth;  ///< points in the current frame, multiples of the baseline

  explicit ExactPair(const Eigen::Vector3d& t, double pixel_noise = 0, uint64_t seed = 1) {
    RelativePose& pose = result.robust.judgement.pose;
    const Eigen::Vector3d rotation = 0.03 * Eigen::Vector3d(1, 2, -1).normalized();
    pose.R = rotationFromVector(rotation);
    pose.t = t.normalized();
    result.robust.judgement.pose_found = true;
    TwoViewSceneOptions options;
    options.matches = 300;
    options.outlier_ratio = 0;
    options.noise_px = pixel_noise;
    options.seed = seed;
    options.farthest = 15;
    options.rotation = -rotation;
    options.translation = -pose.R.transpose() * pose.t;
    const TwoViewScene scene = makeTwoViewScene(options);
    camera = scene.camera;
    for (int i = 0; i < options.matches; ++i) {
      const auto k = static_cast<size_t>(i);
      truth.push_back(scene.R * scene.points[k] + scene.t);
      reference.keypoints.emplace_back(scene.pairs.x_reference[k], scene.pairs.y_reference[k], 31.f);
      current.keypoints.emplace_back(scene.pairs.x_current[k], scene.pairs.y_current[k], 31.f);
      result.matches.push_back({i, i, 10, 50});
      result.current_pixel.push_back(current.keypoints.back().pt);
    }
    result.inlier.assign(truth.size(), 1);
    result.keypoints_reference = result.keypoints_current = result.inliers = options.matches;
    reference.image_size = current.image_size = camera.imageSize();
  }
  /// Leaves the inliers for which `keep(i)`.
  template <typename Keep>
  void keepInliers(const Keep& keep) {
    result.inliers = 0;
    for (size_t i = 0; i < truth.size(); ++i) result.inliers += result.inlier[i] = keep(i);
  }
  Triangulation triangulated() const {
    Triangulation points;
    triangulateInliers(reference, result, camera, points);
    return points;
  }
};

TEST(Triangulation, RecoversThePointsOfAnExactPair) {
  const ExactPair exact({1, 0.2, 0.1});
  const Triangulation points = exact.triangulated();
  ASSERT_EQ(points.size(), 300);
  for (int i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(points.valid[i]);
    EXPECT_NEAR(points.depth_current[i], exact.truth[i].z(), 2e-3 * exact.truth[i].z());  // pixels are floats
    EXPECT_LT((points.point(i) - exact.truth[i]).norm(), 2e-3 * exact.truth[i].norm());
    const RelativePose& pose = exact.result.robust.judgement.pose;
    EXPECT_NEAR(points.depth_reference[i], (pose.R * exact.truth[i] + pose.t).z(), 2e-3 * exact.truth[i].norm());
    const Eigen::Vector3d from_reference = exact.truth[i] + pose.R.transpose() * pose.t;
    const double angle = std::acos(from_reference.normalized().dot(exact.truth[i].normalized()));
    EXPECT_NEAR(points.parallax[i], angle, 1e-4);
  }
}

TEST(Triangulation, FlagsWhatCannotBeATrianglePoint) {
  Triangulation points;
  points.row = {0, 1, 2};
  points.x_reference = {0.1, -0.1, 0.0};
  points.y_reference = {0, 0, 0};
  points.x_current = {0.0, 0.0, -1e-4};  // in front; behind both cameras (diverging rays); no parallax
  points.y_current = {0, 0, 0};
  RelativePose pose;
  pose.t = {1, 0, 0};
  triangulate(pose, kMinimumParallax, points);
  EXPECT_EQ(points.valid, (std::vector<uint8_t>{1, 0, 0}));
  EXPECT_NEAR(points.depth_current[0], 10, 1e-9);
}

TEST(Triangulation, NothingWithoutAPoseOrOfRejectedMatches) {
  ExactPair exact({1, 0, 0});
  exact.keepInliers([](size_t i) { return i < 10; });
  EXPECT_EQ(exact.triangulated().size(), 10);
  ExactPair uncalibrated = exact;
  uncalibrated.camera = Camera();
  EXPECT_EQ(uncalibrated.triangulated().size(), 0);
  exact.result.robust.judgement.pose_found = false;
  EXPECT_EQ(exact.triangulated().size(), 0);
}

TEST(TranslationScale, WithLengthScalesTheCovarianceAndFillsItAlongTheMotion) {
  RelativePose unit;
  unit.t = {0, 0, 1};
  unit.covariance.diagonal() << 0.01, 0.01, 0, 1e-4, 1e-4, 1e-4;
  const RelativePose pose = withLength(unit, {2, 0.05, 100});
  EXPECT_EQ(pose.t, Eigen::Vector3d(0, 0, 2));
  EXPECT_NEAR(pose.covariance(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(pose.covariance(2, 2), 0.01, 1e-12);
  EXPECT_NEAR(pose.covariance(3, 3), 1e-4, 1e-15);
}

TEST(ScalePropagator, FirstPairHasLengthOneAndTooFewCommonFeaturesKeepTheLast) {
  const ExactPair exact({1, 0, 0});
  const Triangulation points = exact.triangulated();
  ScalePropagator propagator;
  ScaleEstimate estimate = propagator.update(points, exact.result, exact.camera);
  EXPECT_EQ(estimate.length, 1);
  EXPECT_EQ(estimate.features, 0);
  EXPECT_EQ(estimate.relative_sigma, 0) << "the unit of all others";
  propagator.advance();
  estimate = propagator.update(Triangulation(), exact.result, exact.camera);
  EXPECT_EQ(estimate.length, 1);
  EXPECT_EQ(estimate.features, 0);
  EXPECT_GE(estimate.relative_sigma, 1) << "a length that nobody measured";
  propagator.reset();
  EXPECT_GE(propagator.update(points, exact.result, exact.camera).relative_sigma, 1) << "a unit of its own";
}

TEST(ScalePropagator, StaysFiniteWhereDepthsLieBeyondInfinity) {
  const ExactPair seen({1, 0, 0});
  ExactPair beyond = seen;
  // The translation reversed: every point has a negative depth.
  beyond.result.robust.judgement.pose.t = -beyond.result.robust.judgement.pose.t;
  const Triangulation points = seen.triangulated(), points_beyond = beyond.triangulated();
  ScalePropagator propagator;
  propagator.update(points, seen.result, seen.camera);
  propagator.advance();
  const ScaleEstimate unmeasured = propagator.update(points_beyond, beyond.result, beyond.camera);
  EXPECT_EQ(unmeasured.length, 1) << "the previous one";
  EXPECT_EQ(unmeasured.features, 0);
  EXPECT_GE(unmeasured.relative_sigma, 1) << "a length that was not measured is not known";
  propagator.advance();
  for (int i = 0; i < 3; ++i) {
    const ScaleEstimate again = propagator.update(points, seen.result, seen.camera);
    EXPECT_TRUE(std::isfinite(again.length) && again.length > 0) << again.length;
    propagator.advance();
  }
  EXPECT_GT(propagator.update(points, seen.result, seen.camera).features, 0);
}

/// Median error of the lengths of a sequence's steps, relative, in units of the first; errors of the scale add up.
template <typename Source>
double propagationError(const Camera& camera, const Source& image, const std::vector<Eigen::Isometry3d>& truth) {
  ScalePropagator propagator;
  std::vector<double> errors;
  double unit = 0;
  forEachPair(camera, static_cast<int>(truth.size()), 1, kMinimumParallax, image,
              [&](int i, const Frame&, const Frame&, const MatchResult& result, const auto& points) {
                ASSERT_TRUE(result.robust.judgement.pose_found) << i;
                const ScaleEstimate scale = propagator.update(points, result, camera);
                propagator.advance();
                const double metres = scale.length / (truth[i].inverse() * truth[i + 1]).translation().norm();
                if (i == 0) unit = metres;
                if (i == 0) return;
                EXPECT_GT(scale.features, 0) << i;
                errors.push_back(std::abs(metres / unit - 1));
              });
  return median(errors);
}

TEST(ScalePropagator, CarriesTheScaleAlongKitti06) {
  OPEN_OR_SKIP(dataset, "kitti_06");
  const Camera camera(*dataset->intrinsics(), dataset->image(0).size());
  std::vector<Eigen::Isometry3d> truth;
  for (const DatasetFrame& frame : dataset->frames()) truth.push_back(*frame.pose);
  EXPECT_LT(propagationError(
                camera, [&](int i) { return dataset->image(i); }, truth),
            0.1);
}

TEST(ScalePropagator, CarriesTheScaleThroughTheRoom) {
  std::vector<Eigen::Isometry3d> truth;
  for (int i = 0; i < 12; ++i) truth.push_back(renderedScene().pose(i));
  EXPECT_LT(propagationError(
                cameraOf(renderedScene()), [](int i) { return renderedFrame(i).image; }, truth),
            0.05);
}

ScaleEstimate poseFromDepth(const Triangulation& pair, const Features& reference, const Features& current,
                            const MatchResult& result, const Camera& camera, const cv::Mat& reference_depth,
                            const cv::Mat& current_depth, RelativePose& pose) {
  return poseFromKeypointDepth({pair,
                                reference,
                                current,
                                result,
                                camera,
                                keypointDepth(reference, reference_depth),
                                keypointDepth(current, current_depth),
                                0,
                                {}},
                               pose);
}

/// Errors of poseFromDepth over pairs of one sequence.
struct DepthErrors {
  std::vector<double> vector, length;              ///< of t, over the true length
  std::vector<double> metres;                      ///< of t
  std::vector<double> normalized_t, normalized_R;  ///< squared, by the covariance, over its dimension

  void add(const RelativePose& pose, const Eigen::Isometry3d& truth) {
    const Eigen::Vector3d t = pose.t - truth.translation();
    const double true_length = truth.translation().norm();
    metres.push_back(t.norm());
    vector.push_back(t.norm() / true_length);
    length.push_back(std::abs(pose.t.norm() / true_length - 1));
    const Eigen::AngleAxisd rotation(truth.linear() * pose.R.transpose());
    const Eigen::Vector3d w = rotation.angle() * rotation.axis();
    normalized_t.push_back(t.dot(Eigen::Matrix3d(pose.covariance.topLeftCorner<3, 3>()).inverse() * t) / 3);
    normalized_R.push_back(w.dot(Eigen::Matrix3d(pose.covariance.bottomRightCorner<3, 3>()).inverse() * w) / 3);
  }
};

/// Errors over the pairs `gap` apart among the first `frames` of a set that has depth for them.
DepthErrors depthErrors(const Dataset& dataset, int frames, int gap) {
  const Camera camera(*dataset.intrinsics(), dataset.image(0).size());
  DepthErrors errors;
  forEachPair(
      camera, frames, gap, kMinimumParallax, [&](int i) { return dataset.image(i); },
      [&](int i, const Frame& a, const Frame& b, const MatchResult& result, const Triangulation& points) {
        RelativePose pose;
        const ScaleEstimate scale = poseFromDepth(points, a.features, b.features, result, camera, dataset.depth(i),
                                                  dataset.depth(i + gap), pose);
        ASSERT_GT(scale.features, 50) << i;
        errors.add(pose, dataset.frames()[i].pose->inverse() * *dataset.frames()[i + gap].pose);
      });
  return errors;
}

TEST(PoseFromDepth, IsMetricOnTheRenderedScene) {
  const Camera camera = cameraOf(renderedScene());
  DepthErrors errors;
  forEachPair(
      camera, 10, 1, kMinimumParallax, [&](int i) { return renderedFrame(10 * (i / 2) + i % 2).image; },
      [&](int k, const Frame& a, const Frame& b, const MatchResult& result, const Triangulation& points) {
        if (k % 2) return;  // pairs of neighbours: frames 0 1, 10 11, ...
        const int i = 5 * k, j = i + 1;
        RelativePose pose;
        const ScaleEstimate scale = poseFromDepth(points, a.features, b.features, result, camera,
                                                  renderedFrame(i).depth, renderedFrame(j).depth, pose);
        ASSERT_GT(scale.features, 100) << i;
        EXPECT_NEAR(scale.length, pose.t.norm(), 1e-12);
        errors.add(pose, renderedScene().pose(i).inverse() * renderedScene().pose(j));
      });
  EXPECT_LT(median(errors.vector), 0.0038);
  for (const auto* normalized : {&errors.normalized_t, &errors.normalized_R}) {
    EXPECT_GT(median(*normalized), 0.3);
    EXPECT_LT(median(*normalized), 3);
  }
}

TEST(PoseFromDepth, AlignedPointsHalveTheErrorOfTheRotation) {
  constexpr double kBaseline = 0.5;  // of two cameras without noise
  const Camera camera = cameraOf(renderedScene("street"));
  std::vector<double> by_keypoints, aligned;
  for (const bool align : {false, true}) {
    MatchFilterOptions options;
    options.align_points = align;
    const auto visit = [&](int k, const Frame& a, const Frame& b, const MatchResult& result,
                           const Triangulation& points) {
      if (k % 2) return;
      const RenderedFrame &reference = renderedFrame(5 * k, "street"), &current = renderedFrame(5 * k + 1, "street");
      const RelativePose truth = trueRelativePose(renderedScene("street"), 5 * k, 5 * k + 1);
      const std::vector<float> zr = keypointDepth(a.features, reference.depth);
      const std::vector<float> zc = keypointDepth(b.features, current.depth);
      const cv::Mat image = align ? reference.image : cv::Mat(), next = align ? current.image : cv::Mat();
      RelativePose pose;
      poseFromKeypointDepth({points, a.features, b.features, result, camera, zr, zc, kBaseline, {}, image, next}, pose);
      (align ? aligned : by_keypoints).push_back(rotationVector(truth.R * pose.R.transpose()).norm());
    };
    forEachPair(
        camera, 12, 1, kMinimumParallax, [](int i) { return renderedFrame(10 * (i / 2) + i % 2, "street").image; },
        visit, options);
  }
  RecordProperty("by_keypoints", std::to_string(median(by_keypoints)));
  RecordProperty("aligned", std::to_string(median(aligned)));
  EXPECT_LT(median(aligned), 0.5 * median(by_keypoints));
}

TEST(PoseFromDepth, IsMetricOnTumFr1Desk) {
  OPEN_OR_SKIP(dataset, "tum_fr1_desk");
  for (const int gap : {2, 4}) {
    const DepthErrors errors = depthErrors(*dataset, static_cast<int>(dataset->frames().size()), gap);
    EXPECT_LT(median(errors.vector), 0.1) << gap;
    EXPECT_LT(median(errors.length), 0.1) << gap;
  }
}

TEST(PoseFromDepth, StaysWithinACentimetreWhereTheCameraOnlyTurns) {
  OPEN_OR_SKIP(dataset, "tum_fr1_rpy");
  constexpr int kFramesWithDepth = 20;
  const DepthErrors errors = depthErrors(*dataset, kFramesWithDepth, 4);
  EXPECT_LT(median(errors.metres), 0.01);
}

ScaleEstimate poseFromDepth(const ExactPair& exact, const cv::Mat& reference_depth, const cv::Mat& current_depth,
                            RelativePose& pose) {
  return poseFromDepth(exact.triangulated(), exact.reference, exact.current, exact.result, exact.camera,
                       reference_depth, current_depth, pose);
}

/// The pixel and the depth at which a camera sees a point that rotates by `row_rotation` from the top row to the
/// bottom.
cv::Point3f seenByRows(const Eigen::Vector3d& point, const Eigen::Vector3d& row_rotation, const Camera& camera) {
  const CameraIntrinsics& k = camera.intrinsics();
  Eigen::Vector3d seen = point;
  const auto row = [&] { return k.fy * seen.y() / seen.z() + k.cy; };
  for (int i = 0; i < 5; ++i) {  // the row it falls on is the row it is read at
    seen = rotationFromVector((0.5 - row() / camera.imageSize().height) * row_rotation) * point;
  }
  return cv::Point3d(k.fx * seen.x() / seen.z() + k.cx, row(), seen.z());
}

TEST(PoseFromDepth, IsNotMisledByARollingShutter) {
  // A floor seen at a slant, where a rotation during the readout looks most like sideways motion. The camera rotates
  // differently during the two images.
  ExactPair exact({1, 0.2, 0.1});
  const RelativePose truth = exact.result.robust.judgement.pose;
  const Eigen::Vector3d normal = Eigen::Vector3d(0.1, 0.8, 0.5).normalized();  // of the floor 8 baselines away
  const Eigen::Vector3d half_rotation(0.002, -0.005, 0.004);
  std::vector<float> depth;
  for (int i = 0; i < 300; ++i) {
    cv::Point2f &r = exact.reference.keypoints[i].pt, &c = exact.current.keypoints[i].pt;
    const Eigen::Vector3d ray = exact.camera.K().inverse() * Eigen::Vector3d(c.x, 280 + 0.3 * c.y, 1);
    const Eigen::Vector3d point = 8 / normal.dot(ray) * ray;
    const cv::Point3f in_reference = seenByRows(truth.R * point + truth.t, -half_rotation, exact.camera);
    const cv::Point3f in_current = seenByRows(point, half_rotation, exact.camera);
    r = {in_reference.x, in_reference.y};
    exact.result.current_pixel[i] = c = {in_current.x, in_current.y};
    depth.push_back(in_current.z);
  }
  RelativePose pose;
  const ScaleEstimate scale = poseFromKeypointDepth(
      {exact.triangulated(), exact.reference, exact.current, exact.result, exact.camera, {}, depth, 0, {}}, pose);
  EXPECT_GT(scale.features, 250);
  EXPECT_LT((pose.t - truth.t).norm(), 0.02);
  EXPECT_LT(rotationVector(pose.R.transpose() * truth.R).norm(), 1e-3);
}

/// Two cameras half a metre apart, whose disparities are too small by so many pixels at x, y.
template <typename Error>
class WrongRig {
 public:
  explicit WrongRig(const Error& too_small) : too_small_(too_small) {}

  /// Error of the translation, metres of one. `noise`: of the disparities, pixels. `every`: stride of the points.
  double translationError(double noise = 0, int every = 1, LearntRig* rig = nullptr) {
    ExactPair exact({0.1, 0.05, 1});
    exact.keepInliers([every](size_t i) { return i % static_cast<size_t>(every) == 0; });
    constexpr double kBaseline = 0.5;
    const double scale = kBaseline * exact.camera.meanFocalLength();
    const Triangulation points = exact.triangulated();
    std::vector<float> depth_reference(exact.truth.size()), depth_current(exact.truth.size());
    for (int i = 0; i < points.size(); ++i) {
      const auto seen = [&](double depth, double x, double y) {
        return static_cast<float>(scale / (scale / depth - too_small_(x, y) + noise * normal_(random_)));
      };
      const auto row = static_cast<size_t>(points.row[i]);
      depth_reference[row] = seen(points.depth_reference[i], points.x_reference[i], points.y_reference[i]);
      depth_current[row] = seen(points.depth_current[i], points.x_current[i], points.y_current[i]);
    }
    RelativePose pose;
    const DepthEstimate estimate = poseFromKeypointDepth({points,
                                                          exact.reference,
                                                          exact.current,
                                                          exact.result,
                                                          exact.camera,
                                                          depth_reference,
                                                          depth_current,
                                                          kBaseline,
                                                          {}},
                                                         pose, nullptr, rig);
    EXPECT_EQ(estimate.features, points.size());
    EXPECT_EQ(estimate.by_sensor.isZero(), rig == nullptr);
    return (pose.t - exact.result.robust.judgement.pose.t).norm();
  }

 private:
  Error too_small_;
  std::mt19937 random_{5};
  std::normal_distribution<double> normal_;
};

TEST(PoseFromDepth, TellsTheErrorOfTheDisparitiesFromTheLength) {
  EXPECT_LT(WrongRig([](double, double) { return 0.8; }).translationError(), 1e-4);
  EXPECT_LT(WrongRig([](double x, double y) { return 0.3 + 0.5 * x - 0.1 * y; }).translationError(), 1e-4);
  // The right camera is yawed: 1e-3 without that in the model.
  EXPECT_LT(WrongRig([](double x, double y) { return 0.15 - 2 * (x * x + y * y); }).translationError(), 1e-4);
}

TEST(LearntRig, HoldsPairsOfFewPoints) {
  const Eigen::Vector4d error(0.5, -0.2, 0.05, 1.5);
  WrongRig cameras([&](double x, double y) { return error.dot(Eigen::Vector4d(1, x, y, x * x + y * y)); });
  constexpr double kNoise = 0.2;
  LearntRig rig;
  EXPECT_FALSE(rig.isOff());
  for (int pair = 0; pair < 50; ++pair) cameras.translationError(kNoise, 2, &rig);
  EXPECT_TRUE(rig.isOff());
  const Eigen::Vector4d deviations = (rig.mean() - error).cwiseQuotient(rig.deviation());
  EXPECT_LT(deviations.cwiseAbs().maxCoeff(), 3) << rig.mean().transpose();
  EXPECT_LT(rig.deviation()[0], 0.1);
  double alone = 0, held = 0;
  for (int pair = 0; pair < 20; ++pair) {
    LearntRig copy = rig;
    alone += cameras.translationError(kNoise, 20);
    held += cameras.translationError(kNoise, 20, &copy);
  }
  EXPECT_LT(held, 0.8 * alone);
}

/// A depth camera that adds so much to every inverse depth, 1/m.
class WrongDepth {
 public:
  explicit WrongDepth(double too_large) : too_large_(too_large) {}

  /// Error of the translation, metres of one.
  double translationError(LearntOffset* offset = nullptr) {
    ExactPair exact({0.5, 0.1, 1}, 0.3, ++seed_);
    exact.result.robust.judgement.sigma_px = 0.3;
    std::vector<float> depth;
    for (const Eigen::Vector3d& point : exact.truth) {
      depth.push_back(static_cast<float>(1 / (1 / point.z() + too_large_ + 0.01 * normal_(random_))));
    }
    RelativePose pose;
    const DepthEstimate estimate = poseFromKeypointDepth(
        {exact.triangulated(), exact.reference, exact.current, exact.result, exact.camera, {}, depth, 0, {}}, pose,
        nullptr, offset);
    EXPECT_GT(estimate.features, 8);
    EXPECT_TRUE(estimate.by_sensor.leftCols<3>().isZero());  // the rotation of the rows is of the pair alone
    EXPECT_EQ(estimate.by_sensor.isZero(), offset == nullptr);
    return (pose.t - exact.result.robust.judgement.pose.t).norm();
  }

 private:
  double too_large_;
  uint64_t seed_ = 0;
  std::mt19937 random_{6};
  std::normal_distribution<double> normal_;
};

TEST(LearntOffset, IsLearntOverPairsAndCorrected) {
  WrongDepth camera(0.015);
  LearntOffset offset;
  EXPECT_FALSE(offset.isOff());
  for (int pair = 0; pair < 50; ++pair) camera.translationError(&offset);
  EXPECT_TRUE(offset.isOff());
  EXPECT_LT(std::abs(offset.mean() + 0.015), 3 * offset.deviation()) << offset.mean();
  EXPECT_LT(offset.deviation(), 0.001);
  double alone = 0, learnt = 0;
  for (int pair = 0; pair < 20; ++pair) {
    LearntOffset copy = offset;
    alone += camera.translationError();
    learnt += camera.translationError(&copy);
  }
  EXPECT_LT(learnt, 0.7 * alone);
}

TEST(LearntOffset, IsNoneWhereThereIsNone) {
  WrongDepth camera(0);
  LearntOffset offset;
  for (int pair = 0; pair < 50; ++pair) camera.translationError(&offset);
  EXPECT_FALSE(offset.isOff());
  EXPECT_LT(std::abs(offset.mean()), 3 * offset.deviation()) << offset.mean();
}

TEST(PoseFromDepth, MatchesWithoutDepthTakePart) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.01);  // of an inverse depth, 1/m
  double with_all = 0, with_depth_alone = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    ExactPair exact({1, 0.2, 0.1}, 0.5, seed);
    exact.result.robust.judgement.sigma_px = 0.5;
    const RelativePose truth = exact.result.robust.judgement.pose;
    std::vector<float> depth;
    for (int i = 0; i < 300; ++i) {
      const double seen = 1 / (1 / exact.truth[i].z() + noise(random));
      depth.push_back(exact.current.keypoints[i].pt.x < 160 ? static_cast<float>(seen) : 0.f);
    }
    const auto error = [&] {
      RelativePose pose;
      const ScaleEstimate scale = poseFromKeypointDepth(
          {exact.triangulated(), exact.reference, exact.current, exact.result, exact.camera, {}, depth, 0, {}}, pose);
      EXPECT_GT(scale.features, 20);
      return rotationVector(pose.R.transpose() * truth.R).norm();
    };
    with_all += error();
    exact.keepInliers([&](size_t i) { return depth[i] > 0; });
    with_depth_alone += error();
  }
  EXPECT_LT(with_all, 0.9 * with_depth_alone);
}

TEST(PoseFromDepth, TakesNoFewerThanEightInliersThoughBothImagesHaveDepth) {
  ExactPair exact({1, 0, 0});
  const cv::Mat_<float> depth(480, 640, 8.f);
  for (const int inliers : {4, 7, 8}) {
    exact.keepInliers([&](size_t i) { return static_cast<int>(i) < inliers; });
    RelativePose pose;
    EXPECT_EQ(poseFromDepth(exact, depth, depth, pose).features, inliers < 8 ? 0 : inliers);
  }
}

TEST(PoseFromDepth, LeavesThePoseAloneWithoutDepth) {
  const ExactPair exact({1, 0, 0});
  RelativePose pose;
  pose.t = {7, 8, 9};
  EXPECT_EQ(poseFromDepth(exact, cv::Mat(), cv::Mat_<float>(480, 640, std::nanf("")), pose).features, 0);
  EXPECT_EQ(pose.t, Eigen::Vector3d(7, 8, 9));
}

}  // namespace
}  // namespace gms_ransac
