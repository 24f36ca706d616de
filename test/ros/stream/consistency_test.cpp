// Errors of the odometry of two cameras against its covariances, on a rendered street with exact truth: with the right
// calibration, and with one that is wrong as real ones are.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "scenes/scene.h"
#include "stream/stream_odometry.h"
#include "two_view/pose_model.h"

namespace gms_ransac {
namespace {

constexpr int kStereoImages = 16;
constexpr double kStereoBaseline = 0.5, kMetresApart = 1, kImagesApart = 0.1;  // metres, metres, seconds

using Covariance = Eigen::Matrix<double, 6, 6>;

double squaredError(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& motion, const Covariance& covariance) {
  Eigen::Matrix<double, 6, 1> error;
  error << truth.translation() - motion.translation(), rotationVector(truth.linear() * motion.linear().transpose());
  return error.dot(covariance.ldlt().solve(error)) / 6;
}

double medianOf(std::vector<double> values) {
  EXPECT_FALSE(values.empty());
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Median of the normalized squared errors.
struct Consistency {
  double pair, one_metre, ten_metres;
};

class RenderedStreet {
 public:
  RenderedStreet() : left_(optionsAt(0)), right_(optionsAt(kStereoBaseline)) {
    for (int i = 0; i < kStereoImages; ++i) {
      images_.push_back({kImagesApart * i, left_.render(i).image, right_.render(i).image, {}});
    }
  }

  /// `wrong`: relative error of focal length and baseline, and of the principal point in focal lengths.
  Consistency drive(double wrong, double systematic_sigma) const {
    OdometryOptions options;
    options.camera = left_.intrinsics();
    options.camera.cx += wrong * options.camera.fx;
    options.camera.fx *= 1 + wrong;
    options.camera.fy *= 1 + wrong;
    options.right = options.camera;
    options.baseline = kStereoBaseline * (1 + wrong);
    options.systematic_sigma = systematic_sigma;
    StreamOdometry odometry(options);
    std::vector<double> pairs, parts[2];
    for (int i = 0; i < kStereoImages; ++i) {
      const OdometryAnswer answer = odometry.add(images_[static_cast<size_t>(i)]);
      EXPECT_TRUE(answer.known) << i;
      if (answer.reference_stamp) {
        Eigen::Isometry3d pair = Eigen::Isometry3d::Identity();
        pair.linear() = answer.pair.R;
        pair.translation() = answer.pair.t;
        pairs.push_back(squaredError(motion(*answer.reference_stamp, i), pair, answer.pair.covariance));
      }
      for (const OdometryPart& part : answer.parts) {
        if (!part.metres) continue;
        parts[part.length > 1].push_back(squaredError(motion(part.from_stamp, i), part.motion, part.covariance));
      }
    }
    return {medianOf(pairs), medianOf(parts[0]), medianOf(parts[1])};
  }

 private:
  static SceneOptions optionsAt(double offset) {
    SceneOptions options;
    options.scene = "street";
    options.size = {640, 320};
    options.step = kMetresApart;
    options.rate = 1 / kImagesApart;
    options.offset = offset;
    return options;
  }
  Eigen::Isometry3d motion(double from, int to) const {
    return left_.pose(static_cast<int>(std::lround(from / kImagesApart))).inverse() * left_.pose(to);
  }

  const Scene left_, right_;
  std::vector<OdometryImages> images_;
};

TEST(Consistency, HoldsWithARightAndAWrongCalibration) {
  const RenderedStreet street;
  const Consistency exact = street.drive(0, 0);
  for (const double nees : {exact.pair, exact.one_metre, exact.ten_metres}) {
    EXPECT_GT(nees, 0.3);
    EXPECT_LT(nees, 3);
  }
  constexpr double kWrong = 0.004, kSystematic = 0.003;
  const Consistency wrong = street.drive(kWrong, kSystematic);
  for (const double nees : {wrong.pair, wrong.one_metre, wrong.ten_metres}) {
    EXPECT_GT(nees, 0.3);
    EXPECT_LT(nees, 3);
  }
  // Own errors alone do not explain it, and the less the longer the way.
  EXPECT_GT(street.drive(kWrong, 0).ten_metres, 8);
}

}  // namespace
}  // namespace gms_ransac
