#include "priors/rotation_comparison.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/core.hpp>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// An explanation leaves at most this share of the contradictions.
constexpr double kExplained = 0.2;
/// Axes are those of another convention if they are so near to signed axes.
constexpr double kAlongAxis = 0.95;  // cosine
/// Weight of unchanged axes where rotations about one axis leave the others open.
constexpr double kUnchanged = 1e-3;

double squaredDistance(const Vector3d& difference, const Matrix3d& covariance) {
  return difference.dot(covariance.inverse() * difference);
}

/// "(x, -z, y)": what the camera's axes are in those that the prior takes for them.
std::string describeAxes(const Matrix3d& axes) {
  std::string text = "(";
  for (int row = 0; row < 3; ++row) {
    int column;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    text += std::string(axes(row, column) < 0 ? "-" : "") + "xyz"[column] + (row < 2 ? ", " : ")");
  }
  return text;
}

}  // namespace

void RotationComparison::add(const ComparedRotation& pair) {
  if (!pair.visual.allFinite() || !pair.prior.allFinite() || !pair.covariance.allFinite()) return;
  if (!compared_.empty() && compared_.back().from == pair.from) compared_.pop_back();
  compared_.push_back(pair);
  if (compared_.size() > kPairs) compared_.pop_front();
}

std::string RotationComparison::agreement() const {
  if (compared_.empty()) return "nothing compared yet";
  const auto pairs = static_cast<double>(compared_.size());
  const long contradict = std::lround(pairs * contradicting());
  if (compared_.size() < kFewest) {
    return cv::format("too few pairs to judge: %ld of %zu contradict the images, and %zu are needed", contradict,
                      compared_.size(), kFewest);
  }
  return cv::format("agrees with the images in %ld of the last %zu pairs", std::lround(pairs) - contradict,
                    compared_.size());
}

double RotationComparison::contradicting(const Matrix3d& axes) const {
  const auto contradicts = [&](const ComparedRotation& pair) {
    return squaredDistance(pair.visual - axes * pair.prior, pair.covariance) > kRotationChi2;
  };
  return static_cast<double>(std::count_if(compared_.begin(), compared_.end(), contradicts)) /
         static_cast<double>(std::max<size_t>(1, compared_.size()));
}

Matrix3d RotationComparison::bestAxes() const {
  Matrix3d sum = Matrix3d::Zero();
  for (const ComparedRotation& pair : compared_) sum += pair.visual * pair.prior.transpose() / pair.covariance.trace();
  sum += kUnchanged * sum.norm() * Matrix3d::Identity();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

std::string RotationComparison::doubt() const {
  if (compared_.size() < kFewest) return std::string();
  const double share = contradicting();
  if (share <= kDoubtful) return std::string();
  const std::string what = cv::format("the rotation prior contradicts the images in %.0f %% of the last %zu pairs",
                                      100 * share, compared_.size());
  const Matrix3d axes = bestAxes();
  if (contradicting(axes) > kExplained) {
    return what +
           "; neither axes, extrinsics nor a time offset of 0.1 s explain it: check that the sensor is on the camera's "
           "body, its clock, its units (radians), and the camera's calibration";
  }
  const std::string remedy = "; correct the tf from the camera's optical frame to the sensor";
  const bool along_axes = axes.cwiseAbs().rowwise().maxCoeff().minCoeff() > kAlongAxis;
  if (along_axes || axes.determinant() < 0) {
    return what + ": its axes explain it; (x, y, z) of the camera by tf is in truth " + describeAxes(axes) + remedy +
           ", or the mounting of the sensor";
  }
  const Vector3d degrees = rotationVector(axes) * 180 / CV_PI;
  return what +
         cv::format(
             ": its extrinsics explain it; rotated by (%.1f, %.1f, %.1f) degrees about the camera's x, "
             "y and z it would agree",
             degrees.x(), degrees.y(), degrees.z()) +
         remedy;
}

}  // namespace gms_ransac
