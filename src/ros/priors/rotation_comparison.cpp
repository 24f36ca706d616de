#include "priors/rotation_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/core.hpp>

#include "priors/rotation_vectors.h"
#include "quantiles.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix4d = Eigen::Matrix4d;
using Vector4d = Eigen::Vector4d;

/// Differences of so many standard deviations and more pull no further (Geman & McClure).
constexpr double kLossSigmas = 3;
/// A shift is searched in steps of a sample of a 100 Hz gyro, then by Gauss-Newton.
constexpr double kShiftStep = 0.01;
constexpr int kShiftIterations = 8;
/// An offset less certain than this is none: a third of a frame of a 30 Hz camera.
constexpr double kLargestOffsetSigma = 0.01;
/// An explanation leaves at most this share of the contradictions.
constexpr double kExplained = 0.2;
constexpr double kDegree = 3.14159265358979323846 / 180;

double squaredDistance(const Vector3d& difference, const Matrix3d& covariance) {
  return difference.dot(covariance.inverse() * difference);
}

double weightOf(double squared) {
  const double bend = kLossSigmas * kLossSigmas;
  const double root = bend / (bend + squared);
  return root * root;
}

/// Sums over the pairs at one shift: the normal equations of shift and constant rate.
struct ShiftEquations {
  Matrix4d H = Matrix4d::Zero();
  Vector4d b = Vector4d::Zero();
  double weighted_squares = 0, weight = 0;
  size_t pairs = 0, contradicting = 0;
};

/// The robust cost of a shift over the pairs that it leaves samples for; infinite where these are less than half.
double costOf(const std::deque<ComparedRotation>& compared, const RotationComparison::RotationBetween& prior,
              double shift) {
  double cost = 0;
  size_t pairs = 0;
  for (const ComparedRotation& pair : compared) {
    const auto there = prior(pair.from + shift, pair.to + shift);
    if (!there) continue;
    const double squared = squaredDistance(pair.visual - *there, pair.covariance);
    cost += kLossSigmas * kLossSigmas * squared / (kLossSigmas * kLossSigmas + squared);
    ++pairs;
  }
  if (2 * pairs < compared.size()) return std::numeric_limits<double>::infinity();
  return cost / static_cast<double>(pairs);
}

ShiftEquations linearize(const std::deque<ComparedRotation>& compared, const RotationComparison::RotationBetween& prior,
                         double shift, const Vector3d& rate) {
  constexpr double kDifference = 1e-3;  // seconds, for the derivative
  ShiftEquations equations;
  for (const ComparedRotation& pair : compared) {
    const auto here = prior(pair.from + shift, pair.to + shift);
    const auto later = prior(pair.from + shift + kDifference, pair.to + shift + kDifference);
    if (!here || !later) continue;
    const double seconds = pair.to - pair.from;
    const Vector3d difference = pair.visual - *here - seconds * rate;
    Eigen::Matrix<double, 3, 4> J;
    J.col(0) = (*later - *here) / kDifference;
    J.rightCols<3>() = seconds * Matrix3d::Identity();
    const Matrix3d information = pair.covariance.inverse();
    const double squared = difference.dot(information * difference);
    const double weight = weightOf(squared);
    equations.H += weight * J.transpose() * information * J;
    equations.b += weight * J.transpose() * (information * difference);
    equations.weighted_squares += weight * squared;
    equations.weight += weight;
    equations.contradicting += squared > kRotationChi2;
    ++equations.pairs;
  }
  return equations;
}

/// "(x, y, z) of the camera are (x, -z, y)" of what the prior takes for the camera's axes.
std::string describeAxes(const Matrix3d& axes) {
  std::string text = "(";
  for (int row = 0; row < 3; ++row) {
    int column;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    text += std::string(axes(row, column) < 0 ? "-" : "") + "xyz"[column] + (row < 2 ? ", " : ")");
  }
  return text;
}

std::vector<Matrix3d> signedPermutations() {
  std::vector<Matrix3d> all;
  int order[3] = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d axes = Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) axes(row, order[row]) = (signs >> row & 1) != 0 ? -1 : 1;
      all.push_back(axes);
    }
  } while (std::next_permutation(order, order + 3));
  // Among equal explanations the smallest change is the likeliest mistake.
  std::stable_sort(all.begin(), all.end(), [](const Matrix3d& a, const Matrix3d& b) { return a.trace() > b.trace(); });
  return all;
}

}  // namespace

void RotationComparison::add(const ComparedRotation& pair) {
  if (!pair.visual.allFinite() || !pair.prior.allFinite() || !pair.covariance.allFinite()) return;
  if (!compared_.empty() && compared_.back().from == pair.from) compared_.pop_back();
  compared_.push_back(pair);
  if (compared_.size() > kPairs) compared_.pop_front();
}

double RotationComparison::contradicting() const { return contradicting(Matrix3d::Identity()); }

double RotationComparison::contradicting(const Matrix3d& axes) const {
  if (compared_.empty()) return 0;
  const auto contradicts = [&](const ComparedRotation& pair) {
    return squaredDistance(pair.visual - axes * pair.prior, pair.covariance) > kRotationChi2;
  };
  return static_cast<double>(std::count_if(compared_.begin(), compared_.end(), contradicts)) /
         static_cast<double>(compared_.size());
}

std::optional<TimeOffset> RotationComparison::timeOffset(const RotationBetween& prior) const {
  if (compared_.size() < kFewest) return std::nullopt;
  double shift = 0, lowest = std::numeric_limits<double>::infinity();
  const int steps = static_cast<int>(std::lround(kLargestOffset / kShiftStep));
  for (int k = -steps; k <= steps; ++k) {
    const double cost = costOf(compared_, prior, k * kShiftStep);
    if (cost >= lowest) continue;
    lowest = cost;
    shift = k * kShiftStep;
  }
  Vector3d rate = Vector3d::Zero();
  ShiftEquations equations = linearize(compared_, prior, shift, rate);
  for (int i = 0; i < kShiftIterations; ++i) {
    const Vector4d step = equations.H.inverse() * equations.b;
    if (!step.allFinite() || std::abs(step[0]) > kLargestOffset) return std::nullopt;
    shift += step[0];
    rate += step.tail<3>();
    equations = linearize(compared_, prior, shift, rate);
    if (std::abs(step[0]) < 1e-6) break;
  }
  if (equations.pairs < kFewest || std::abs(shift) > kLargestOffset) return std::nullopt;
  // The residuals scale the covariances, but never down.
  const double scale = std::max(1.0, equations.weighted_squares / std::max(1.0, 3 * equations.weight - 4));
  TimeOffset offset;
  offset.seconds = shift;
  offset.sigma = std::sqrt(scale * equations.H.inverse()(0, 0));
  if (!(offset.sigma <= kLargestOffsetSigma)) return std::nullopt;
  offset.explains = static_cast<double>(equations.contradicting) <= kExplained * static_cast<double>(equations.pairs);
  return offset;
}

RotationComparison::Axes RotationComparison::bestAxes() const {
  static const std::vector<Matrix3d> all = signedPermutations();
  Axes best = {Matrix3d::Identity(), contradicting()};
  for (const Matrix3d& axes : all) {
    const double left = contradicting(axes);
    if (left < best.contradicting) best = {axes, left};
  }
  return best;
}

RotationComparison::Axes RotationComparison::bestRotation() const {
  Matrix3d sum = Matrix3d::Zero();
  for (const ComparedRotation& pair : compared_) sum += pair.visual * pair.prior.transpose() / pair.covariance.trace();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs = Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {R, contradicting(R)};
}

std::string RotationComparison::doubt(const std::optional<TimeOffset>& offset) const {
  if (compared_.size() < kFewest) return std::string();
  const double share = contradicting();
  if (share <= kDoubtful) return std::string();
  const std::string what = cv::format("the rotation prior contradicts the images in %.0f %% of the last %zu pairs",
                                      100 * share, compared_.size());
  if (offset && offset->explains) {
    return what + cv::format(
                      ": a time offset explains it; add %+.4f s (standard deviation %.4f s) to "
                      "~image_time_offset",
                      offset->seconds, offset->sigma);
  }
  const Axes axes = bestAxes();
  if (axes.contradicting <= kExplained) {
    return what + ": its axes explain it; (x, y, z) of the camera by tf is in truth " + describeAxes(axes.matrix) +
           "; correct the tf from the camera's optical frame to the sensor, or the mounting of the sensor";
  }
  const Axes rotation = bestRotation();
  if (rotation.contradicting <= kExplained) {
    const Vector3d degrees = vectorOf(rotation.matrix) / kDegree;
    return what + cv::format(
                      ": its extrinsics explain it; rotated by (%.1f, %.1f, %.1f) degrees about the camera's x, "
                      "y and z it would agree; correct the tf from the camera's optical frame to the sensor",
                      degrees.x(), degrees.y(), degrees.z());
  }
  std::vector<double> angles;
  for (const ComparedRotation& pair : compared_) angles.push_back(pair.visual.norm());
  return what + cv::format(
                    " (of %.2f degrees usually); neither axes, extrinsics nor a time offset explain it: check "
                    "that the sensor is on the camera's body, its units (radians), and the camera's calibration",
                    quantilesOf(std::move(angles)).median / kDegree);
}

}  // namespace gms_ransac
