// The last gate before publishing: no pose passes it that is not finite, with a rotation and a covariance, in no scale
// mode and on no sequence.
#include "stream/pair_pose.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "datasets/dataset.h"
#include "processor_stream.h"
#include "says.h"
#include "scenes/scene.h"
#include "shared_data.h"
#include "stream/status_text.h"

namespace gms_ransac {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

RelativePose fitPose() {
  RelativePose pose;
  pose.R = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.t = {0.6, 0, 0.8};
  pose.covariance.diagonal() << 1e-3, 2e-3, 1e-3, 1e-6, 1e-6, 2e-6;
  pose.covariance(0, 4) = pose.covariance(4, 0) = 1e-6;
  return pose;
}

TEST(PoseDefect, NamesEveryDefect) {
  EXPECT_EQ(poseDefect(fitPose()), "");
  const auto defectAfter = [](auto&& spoil) {
    RelativePose pose = fitPose();
    spoil(pose);
    return poseDefect(pose);
  };
  for (const double value : {kNan, kInfinity, -kInfinity}) {
    EXPECT_EQ(defectAfter([=](RelativePose& p) { p.t.y() = value; }), "its translation is not finite");
    EXPECT_EQ(defectAfter([=](RelativePose& p) { p.R(1, 2) = value; }), "its rotation is not finite");
    EXPECT_EQ(defectAfter([=](RelativePose& p) { p.covariance(2, 3) = value; }), "its covariance is not finite");
  }
  const std::string no_rotation = "its rotation matrix is not a rotation";
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.R *= 1 + 1e-8; }), no_rotation);
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.R(0, 1) += 1e-6; }), no_rotation);
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.R = -p.R; }), no_rotation);
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.R.setZero(); }), no_rotation);
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.covariance(0, 4) = 0; }), "its covariance is not symmetric");
  const std::string not_definite = "its covariance is not positive definite";
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.covariance(1, 1) = -1e-3; }), not_definite);
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.covariance(0, 1) = p.covariance(1, 0) = 2e-3; }), not_definite);
  EXPECT_EQ(defectAfter([](RelativePose& p) { p.covariance.setZero(); }), not_definite);
}

TEST(MakePublishable, HidesNoDefect) {
  for (const bool translation_known : {true, false}) {
    RelativePose pose = fitPose();
    makePublishable(translation_known, {}, pose);
    EXPECT_EQ(poseDefect(pose), "");
    for (const double value : {kNan, kInfinity, -1.0}) {
      pose = fitPose();
      pose.covariance(4, 4) = value;
      makePublishable(translation_known, {}, pose);
      EXPECT_NE(poseDefect(pose), "") << value;
    }
  }
}

TEST(MakePublishable, EvensOutTheRoundingOfAnInverse) {
  RelativePose pose = fitPose();
  pose.covariance(4, 0) *= 1 + 1e-4;
  makePublishable(true, {}, pose);
  EXPECT_EQ(poseDefect(pose), "");
  pose.covariance(4, 0) = -pose.covariance(0, 4);
  makePublishable(true, {}, pose);
  EXPECT_EQ(poseDefect(pose), "its covariance is not symmetric");
}

TEST(MakePublishable, MakesDegenerateCovariancesDefinite) {
  for (const double length : {1e-6, 1.0, 1e6}) {
    for (const double floor : {4e-5, 0.005, 3.0}) {
      RelativePose pose = fitPose();
      pose.t *= length;
      // Nothing known of x, everything of the rest: as bad as it comes.
      pose.covariance = Covariance6d::Zero();
      pose.covariance(0, 0) = length * length;
      makePublishable(true, {floor, floor}, pose);
      EXPECT_EQ(poseDefect(pose), "") << length << " " << floor;
    }
  }
}

void expectFitOrNoPose(const ProcessedFrame& processed) {
  if (!processed.poseValid()) return;
  EXPECT_EQ(poseDefect(processed.pose), "") << statusName(processed.status);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(processed.pose.covariance);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0);
}

void expectStopped(const ProcessedFrame& processed, const std::string& defect) {
  EXPECT_EQ(processed.status, MatchStats::RANSAC_FAILED);
  EXPECT_FALSE(processed.poseValid());
  EXPECT_TRUE(says(processed.text, {"not fit to publish", defect}));
}

TEST(PoseGate, GuardsEveryScaleMode) {
  const Scene scene{SceneOptions()};
  ProcessorOptions spoilt, spoilt_later;
  spoilt.sigma_floor.rotation = kNan;
  spoilt_later.systematic_sigma = kNan;
  const auto secondFrame = [&scene](ScaleMode scale, const ProcessorOptions& options, double fixed_scale, auto judge) {
    ImageStream stream(scale, scene.intrinsics(), options, fixed_scale);
    for (int i = 0; i < 2; ++i) {
      const RenderedFrame frame = scene.render(i);
      const ProcessedFrame processed =
          stream.process(frame.image, scale == ScaleMode::kDepth ? frame.depth : cv::Mat_<float>());
      if (i == 1) judge(processed);
    }
  };
  for (const ScaleMode scale : {ScaleMode::kUnit, ScaleMode::kPropagate, ScaleMode::kDepth, ScaleMode::kFixed,
                                ScaleMode::kOdometry, ScaleMode::kGround}) {
    secondFrame(scale, ProcessorOptions(), 2, [](const ProcessedFrame& processed) {
      EXPECT_EQ(processed.status, MatchStats::OK) << processed.text;
      expectFitOrNoPose(processed);
    });
    for (const ProcessorOptions& options : {spoilt, spoilt_later}) {
      secondFrame(scale, options, 2,
                  [](const ProcessedFrame& processed) { expectStopped(processed, "covariance is not finite"); });
    }
  }
  secondFrame(ScaleMode::kFixed, ProcessorOptions(), kNan,
              [](const ProcessedFrame& processed) { expectStopped(processed, "translation is not finite"); });
}

TEST(PoseGate, NothingUnfitComesOfTurningBackAndForth) {
  OPEN_OR_SKIP(dataset, "tum_fr1_rpy");
  std::vector<cv::Mat> images;
  for (size_t i = 0; i < dataset->frames().size(); ++i) images.push_back(dataset->image(static_cast<int>(i)));
  const int n = static_cast<int>(images.size());
  constexpr int kPasses = 3;
  for (const auto& [method, model] :
       {std::pair("cp_ransac", ModelType::kEssential), std::pair("ransac", ModelType::kEssential),
        std::pair("lo_prosac", ModelType::kHomography), std::pair("lo_prosac", ModelType::kEssential)}) {
    SCOPED_TRACE(std::string(method) + " " + toString(model));
    ProcessorOptions options;
    options.core.method = method;
    options.core.robust.model = model;
    ImageStream stream(ScaleMode::kPropagate, *dataset->intrinsics(), options);
    int ok = 0, stopped = 0;
    for (int i = 0; i < kPasses * n; ++i) {
      const int phase = i % (2 * n);
      const ProcessedFrame processed =
          stream.process(images[static_cast<size_t>(phase < n ? phase : 2 * n - 1 - phase)]);
      expectFitOrNoPose(processed);
      ok += processed.status == MatchStats::OK;
      stopped += processed.text.find("not fit to publish") != std::string::npos;
    }
    EXPECT_GT(ok, 0);
    EXPECT_EQ(stopped, 0) << "the gate is for unforeseen errors";
  }
}

}  // namespace
}  // namespace gms_ransac
