// The mask that is learnt over drawn streams of points in space, and of points that stay on a part of the image.
#include "gms_ransac/learned_mask.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "gms_ransac/match_filter.h"
#include "past/mask_learner.h"
#include "past/pixel_motion.h"
#include "scenes/drawn_sequences.h"
#include "support/random.h"
#include "two_view/pose_model.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const cv::Size kImage(640, 480);

/// A room full of points, seen by a sceneCamera() that may carry something in the lower part of its view.
class Stream {
 public:
  explicit Stream(uint64_t seed = 1) : random_(seed), filter_(MatchFilterOptions()) {
    filter_.setCamera(sceneCamera());
    cv::Mat rows(kPoints + kCarried, kDescriptorBytes, CV_8U);
    cv::RNG(seed).fill(rows, cv::RNG::UNIFORM, 0, 256);
    descriptors_ = rows;
    for (int k = 0; k < kPoints; ++k) {
      const Vector3d ray = inCube(random_);
      points_.push_back((3 + 5 * random_.uniform()) * Vector3d(1.2 * ray.x(), ray.y(), 1));
    }
    for (int k = 0; k < kCarried; ++k) carried_.push_back({640 * random_.uniform(), random_.uniform()});
  }

  /// The next image, from there; `share`: of the view below which something is fixed to the camera.
  const MatchResult& look(const Isometry3d& pose, double share = 0) {
    const double top = kImage.height * (1 - share);
    Features features;
    features.image_size = kImage;
    cv::Mat rows(0, kDescriptorBytes, CV_8U);
    const auto add = [&](const Vector2d& pixel, int row) {
      const double x = pixel.x() + kNoise * gaussian(random_), y = pixel.y() + kNoise * gaussian(random_);
      if (x < 0 || y < 0 || x > kImage.width - 1 || y > kImage.height - 1) return;
      features.keypoints.emplace_back(static_cast<float>(x), static_cast<float>(y), 31.f, 0.f, 1.f, 0);
      rows.push_back(descriptors_.row(row));
    };
    for (int k = 0; k < kPoints; ++k) {
      const Vector3d seen = pose.inverse() * points_[static_cast<size_t>(k)];
      const Vector2d pixel = (sceneCamera().K() * seen).hnormalized();
      if (seen.z() > 0.3 && pixel.y() < top) add(pixel, k);
    }
    for (int k = 0; k < kCarried && share > 0; ++k) {
      const Vector2d& place = carried_[static_cast<size_t>(k)];
      add({place.x(), top + (kImage.height - top) * place.y()}, kPoints + k);
    }
    features.descriptors.assign(rows);
    return filter_.process(features);
  }

  MatchFilter& filter() { return filter_; }

 private:
  static constexpr int kPoints = 2400, kCarried = 400;
  static constexpr double kNoise = 0.1;  // pixels

  Random random_;
  MatchFilter filter_;
  cv::Mat descriptors_;
  std::vector<Vector3d> points_;
  std::vector<Vector2d> carried_;
};

/// A hand that sways: 3 cm and a degree from image to image.
Isometry3d swaying(int image, double speed = 1) {
  const double phase = 0.35 * speed * image;
  Isometry3d pose(rotationFromVector(0.06 * Vector3d(std::sin(phase), std::cos(0.8 * phase), std::sin(0.5 * phase))));
  pose.translation() = 0.12 * Vector3d(std::cos(phase), std::sin(0.9 * phase), std::cos(0.6 * phase));
  return pose;
}

/// Images until the mask covers `share` of the view from below, at most 60: nine cells of ten there, as some hold no
/// keypoint, and none above. The row of cells at the edge may be either.
int imagesUntil(Stream& stream, double share, int image = 0) {
  for (int n = 1; n <= 60; ++n) {
    const LearnedMask mask = stream.look(swaying(image + n), share).mask;
    int below = 0, covered_below = 0, covered_above = 0;
    for (float y = 12; y < kImage.height; y += 24) {
      const double edge = kImage.height * (1 - share) - y;
      for (float x = 16; x < kImage.width && std::abs(edge) > 24; x += 32) {
        below += edge < 0;
        (edge < 0 ? covered_below : covered_above) += mask.covers({x, y});
      }
    }
    if (10 * covered_below >= 9 * below && covered_above == 0) return n;
  }
  return 61;
}

TEST(LearnedMask, WhatTheCameraCarriesIsLeftOut) {
  for (const double share : {0.12, 0.25, 0.4}) {
    Stream stream;
    EXPECT_LE(imagesUntil(stream, share), 30) << share;
    int known = 0;
    for (int image = 61; image <= 70; ++image) {
      const MatchResult& result = stream.look(swaying(image), share);
      known += result.status == Status::kOk;
      EXPECT_NEAR(result.mask.share(), share, 0.06);
      EXPECT_GT(result.masked.size(), 100U);
      for (const Match& match : result.raw) {
        ASSERT_FALSE(result.mask.covers(stream.filter().reference().features.keypoints[match.reference].pt));
      }
    }
    EXPECT_GE(known, 9) << share;
  }
}

TEST(LearnedMask, IsForgottenWhereTheSceneShowsThrough) {
  Stream stream;
  const int closed = imagesUntil(stream, 0.25);
  ASSERT_LE(closed, 30);
  EXPECT_LE(imagesUntil(stream, 0, closed), 10);
}

TEST(LearnedMask, ACameraAtRestAndASlowStartCoverNothing) {
  Stream stream;
  for (int n = 0; n < 30; ++n) EXPECT_TRUE(stream.look(swaying(0)).mask.empty());
  for (int n = 0; n < 30; ++n) EXPECT_TRUE(stream.look(swaying(n, 0.02)).mask.empty());
  for (int n = 0; n < 30; ++n) EXPECT_TRUE(stream.look(swaying(n, 0.02 + 0.03 * n)).mask.empty());
}

TEST(LearnedMask, ABodyBeforeACameraAtRestCoversNothing) {
  MatchFilter filter{MatchFilterOptions()};
  filter.setCamera(sceneCamera());
  for (const DrawnSequence& sequence : drawnSequences()) {
    for (int index = 0; index < 3 && sequence.camera == CameraPath::kStanding; ++index) {
      filter.reset();
      for (const DrawnImage& image : drawSequence(sequence, index)) {
        EXPECT_TRUE(filter.process(image.features).mask.empty()) << sequence.name << ' ' << index;
      }
    }
  }
}

TEST(LearnedMask, IsTheCamerasAndEndsWithIt) {
  Stream stream;
  ASSERT_LE(imagesUntil(stream, 0.25), 30);
  Past past;
  past.startPair(stream.filter().reference().features, stream.filter().current().features);
  past.mask = stream.look(swaying(61), 0.25).mask;
  const LearnedMask learnt = past.mask;
  past.startPair(stream.filter().current().features, stream.filter().reference().features);  // the chain breaks
  EXPECT_EQ(past.mask, learnt);
  Features larger = stream.filter().current().features;
  larger.image_size = {1280, 960};
  past.startPair(larger, larger);
  EXPECT_TRUE(past.mask.empty());
  stream.filter().reset();
  stream.look(swaying(62), 0.25);
  EXPECT_TRUE(stream.look(swaying(63), 0.25).mask.empty());
}

/// A keypoint in the middle of each cell, matched from image to image as if the camera had rotated to the right. Those
/// of the lowest five rows may stay in place.
struct Rotation {
  Rotation() : camera(sceneCamera()) {
    view.rotation_observable = view.pose_found = true;
    view.pose.R = view.motion.R = rotationFromVector({0, 0.03, 0});
    view.pose.covariance = view.motion.covariance = Covariance6d::Identity() * 1e-8;
    const PixelMotion motion(camera, view.pose);
    for (Features* image : {&reference, &current, &fixed}) image->image_size = kImage;
    for (float y = 12; y < kImage.height; y += 24) {
      for (float x = 16; x < kImage.width; x += 32) {
        const Vector2d there = motion.toCurrent({x, y});
        const cv::Point2f moved(static_cast<float>(there.x()), static_cast<float>(there.y()));
        reference.keypoints.emplace_back(x, y, 31.f, 0.f, 1.f, 0);
        current.keypoints.emplace_back(moved, 31.f, 0.f, 1.f, 0);
        fixed.keypoints.emplace_back(y > 360 ? cv::Point2f(x, y) : moved, 31.f, 0.f, 1.f, 0);
        Match& match = result.raw.emplace_back();
        match.reference = match.current = static_cast<int32_t>(result.raw.size() - 1);
      }
    }
  }
  void learn(const Features& image, LearnedMask& mask) { learnMask(reference, image, camera, result, view, mask); }

  Camera camera;
  Judgement view;
  Features reference, current, fixed;
  MatchResult result;
};

TEST(LearnedMask, TenThousandImagesWeighNoMoreThanTen) {
  Rotation rotation;
  LearnedMask ten(kImage), many(kImage);
  for (int n = 0; n < 10; ++n) rotation.learn(rotation.fixed, ten);
  for (int n = 0; n < 10000; ++n) rotation.learn(rotation.fixed, many);
  EXPECT_EQ(ten.share(), 0.25);
  EXPECT_EQ(many, ten);
  int images = 0;
  for (; !many.empty() && images < 10; ++images) rotation.learn(rotation.current, many);
  EXPECT_EQ(images, 3) << "to forget";
}

TEST(LearnedMask, IsAnImageAsExtractorsTakeIt) {
  LearnedMask mask({640, 480});
  for (int pair = 0; pair < 10; ++pair) mask.add(mask.cellOf({33, 25}), true);
  EXPECT_FALSE(mask.empty());
  const cv::Mat image = mask.toImage();
  EXPECT_EQ(image.size(), kImage);
  EXPECT_EQ(cv::countNonZero(image == 0), 32 * 24);
  EXPECT_EQ(image.at<uint8_t>(25, 33), 0);
  EXPECT_EQ(image.at<uint8_t>(0, 0), 255);
  const LearnedMask before = mask;
  for (int pair = 0; pair < 3; ++pair) mask.add(mask.cellOf({33, 25}), false);
  EXPECT_TRUE(mask.empty());
  EXPECT_NE(mask, before);
}

}  // namespace
}  // namespace gms_ransac
