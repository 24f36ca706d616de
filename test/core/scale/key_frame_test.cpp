// The motion since an earlier image: drawn points, seen by a rig of two cameras that drives on.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "scale/depth_pose.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

constexpr int kPoints = 300, kLastImage = 6;
constexpr double kRigBaseline = 0.5, kRigNoise = 0.5, kRigDisparityNoise = 0.2;  // metres, pixels, pixels

struct RigView {
  Features features;
  std::vector<float> depth;
};

class KeyFrameTest : public testing::Test {
 protected:
  KeyFrameTest() : camera_({500, 500, 320, 240, {}, {}}, cv::Size(640, 480)) {}

  /// The pose of an image in the one before it.
  RelativePose step() const {
    RelativePose step;
    step.R = rotationFromVector({0.01, 0.02, -0.01});
    step.t = {0.05, -0.02, 0.3};
    return step;
  }

  RigView look(const RelativePose& camera) {
    RigView view;
    view.features.image_size = camera_.imageSize();
    view.features.scale_factor = 1.2f;
    std::normal_distribution<double> noise;
    for (const Eigen::Vector3d& point : points_) {
      const Eigen::Vector3d seen = camera.R.transpose() * (point - camera.t);
      view.features.keypoints.emplace_back(
          static_cast<float>(320 + 500 * seen.x() / seen.z() + kRigNoise * noise(random_)),
          static_cast<float>(240 + 500 * seen.y() / seen.z() + kRigNoise * noise(random_)), 31.f);
      const double scale = 500 * kRigBaseline;
      view.depth.push_back(static_cast<float>(scale / (scale / seen.z() + kRigDisparityNoise * noise(random_))));
    }
    return view;
  }

  /// A drive: its last image in the first one by the key frame, and by the pairs alone. One of `lasting_` tracks
  /// ends after `life` images, the others with each. `all_last`: no track ends before.
  void drive(int life, bool all_last = false) {
    std::uniform_real_distribution<double> across(-1, 1), along(5, 20);
    points_.clear();
    for (int i = 0; i < kPoints; ++i) {
      const double z = along(random_);
      points_.emplace_back(0.5 * z * across(random_), 0.35 * z * across(random_), z);
    }
    key_ = KeyFrame();
    chain_ = truth_ = RelativePose();
    RigView reference = look(truth_);
    for (int image = 1; image <= kLastImage; ++image) {
      truth_ = chained(truth_, step());
      RigView current = look(truth_);
      MatchResult result;
      result.robust.judgement.pose_found = true;
      result.robust.judgement.sigma_px = kRigNoise;
      result.robust.judgement.pose = step();
      result.robust.judgement.pose.t.normalize();
      result.shutter.kind = shutter_;
      std::vector<uint32_t> tracks;
      for (int i = 0; i < kPoints; ++i) {
        result.matches.push_back({i, i, 10, 50});
        result.current_pixel.push_back(current.features.keypoints[static_cast<size_t>(i)].pt);
        // Every other pair of images finds the rest of the points: their noise does not cancel out in the next pair.
        const bool lasts = all_last || i % lasting_ == 0, found = lasts || (i + image) % 2 == 0;
        result.inlier.push_back(found);
        result.inliers += found;
        tracks.push_back(static_cast<uint32_t>(1 + kPoints * (lasts ? (image - 1) / life : image) + i));
      }
      Triangulation columns;
      triangulateInliers(reference.features, result, camera_, columns);
      RelativePose pair;
      ASSERT_GT(poseFromKeypointDepth({columns, reference.features, current.features, result, camera_, reference.depth,
                                       current.depth, baseline_, tracks},
                                      pair, &key_)
                    .features,
                0);
      EXPECT_EQ(key_.is_reference, ends_with_each_ || (image - 1) % life == 0) << image;
      chain_ = chained(chain_, pair);
      key_.advance();
      reference = current;
    }
  }

  Eigen::Matrix<double, 6, 1> error(const RelativePose& pose) const {
    Eigen::Matrix<double, 6, 1> e;
    e << truth_.t - pose.t, rotationVector(truth_.R * pose.R.transpose());
    return e;
  }

  double baseline_ = kRigBaseline;
  Shutter::Kind shutter_ = Shutter::kUnknown;
  int lasting_ = 4;
  bool ends_with_each_ = false;  ///< expected of the key frame
  Camera camera_;
  std::mt19937 random_{1};
  std::vector<Eigen::Vector3d> points_;
  KeyFrame key_;
  RelativePose chain_, truth_;
};

TEST_F(KeyFrameTest, TheNoiseOfThePairsBetweenDoesNotAddUp) {
  constexpr int kDrives = 40;
  double of_chain[2] = {}, of_key[2] = {}, normalized = 0;
  for (int i = 0; i < kDrives; ++i) {
    drive(kLastImage);
    const auto by_chain = error(chain_), by_key = error(key_.current);
    for (const int half : {0, 1}) {
      of_chain[half] += by_chain.segment<3>(3 * half).squaredNorm();
      of_key[half] += by_key.segment<3>(3 * half).squaredNorm();
    }
    normalized += by_key.dot(key_.current.covariance.inverse() * by_key) / 6 / kDrives;
  }
  for (const int half : {0, 1}) EXPECT_LT(std::sqrt(of_key[half]), 0.95 * std::sqrt(of_chain[half])) << half;
  EXPECT_GT(normalized, 0.4);
  EXPECT_LT(normalized, 2.5);
}

TEST_F(KeyFrameTest, PointsThatAllPairsSawTellNothingNew) {
  // The noise of the images between cancels out in the chain: it ends as the key frame's own answer does.
  constexpr int kDrives = 40;
  double normalized = 0;
  for (int i = 0; i < kDrives; ++i) {
    drive(kLastImage, true);
    const auto e = error(key_.current);
    normalized += e.dot(key_.current.covariance.inverse() * e) / 6 / kDrives;
  }
  EXPECT_GT(normalized, 0.4);
  EXPECT_LT(normalized, 1.3);
}

TEST_F(KeyFrameTest, IsTheReferenceWhereItIsSeenNoMore) {
  drive(3);
  const RelativePose half = chained(chained(step(), step()), step());
  EXPECT_LT((key_.current.t - half.t).norm(), 0.05);
  drive(1);
  EXPECT_LT((key_.current.t - step().t).norm(), 0.05);
}

TEST_F(KeyFrameTest, WhereTheShutterMayRollItEndsEarlier) {
  lasting_ = 8;  // a fifth of its points are still seen
  drive(kLastImage);
  baseline_ = 0;
  shutter_ = Shutter::kGlobal;
  drive(kLastImage);
  ends_with_each_ = true;
  shutter_ = Shutter::kUnknown;
  drive(kLastImage);
  shutter_ = Shutter::kRolling;
  drive(kLastImage);
}

}  // namespace
}  // namespace gms_ransac
