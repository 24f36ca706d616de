#include "run/truth.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr double kMovedDeviations = 10;  // of the truth's noise
constexpr double kRounding = 1e-6;       // metres, of exact poses that were written as text
constexpr double kDegree = M_PI / 180;
constexpr double kLoosestLabel = 10;                      // pixels
constexpr double kDeviations = 2;                         // of the truth's noise that a label allows for
constexpr int kReach = static_cast<int>(kCorrectWithin);  // of surfaces about a keypoint, pixels
constexpr double kNearest = 1;                            // metres; closest point to a camera that has not moved

/// A 30 Hz camera without a trigger: its stamp is uniform between two frames. Seconds.
const double kFrameClock = 1 / 30. / std::sqrt(12.);

struct KindOfTruth {
  const char* word;  ///< in the set's name, in small letters
  TruthNoise noise;
};
const KindOfTruth kKinds[] = {
    {"rendered", {0, 0, 0, 0}},
    {"kitti", {0.01 * kDegree, 0.005, 0, 0.1 * kDegree}},
    {"euroc", {0.05 * kDegree, 0.001, 0, 0}},
    {"7scenes", {0.2 * kDegree, 0.01, kFrameClock, 0}},
    {"tum", {0.2 * kDegree, 0.001, kFrameClock, 0}},
    {"freiburg", {0.2 * kDegree, 0.001, kFrameClock, 0}},
};

/// The true motion of a pair whose images were taken `later` seconds after their stamps.
std::optional<Isometry3d> motion(const Dataset& dataset, const DatasetPair& pair, double later) {
  const auto poseOf = [&](int frame) -> std::optional<Isometry3d> {
    const std::optional<double> stamp = dataset.stamp(frame);
    return stamp ? dataset.truthAt(*stamp + later) : std::nullopt;
  };
  const auto reference = poseOf(pair.reference), current = poseOf(pair.current);
  if (!reference || !current) return std::nullopt;
  return reference->inverse() * *current;
}

/// Covariance of a vector in axes that are rotated by `sigma` about each.
Matrix3d byRotation(double sigma, const Vector3d& v) {
  return sigma * sigma * (v.squaredNorm() * Matrix3d::Identity() - v * v.transpose());
}

Vector3d homogeneous(const cv::Point2f& p) { return {p.x, p.y, 1}; }

/// Larger distance of p from the line M q and of q from the line M^T p, for p^T M q = 0.
double symmetricDistance(const Matrix3d& M, const Vector3d& p, const Vector3d& q) {
  const Vector3d line_p = M * q, line_q = M.transpose() * p;
  const double residual = std::abs(p.dot(line_p));
  return std::max(residual / line_p.head<2>().norm(), residual / line_q.head<2>().norm());
}

/// Values within `reach` of the nearest pixel, but those outside and at 0; none where there is none at that pixel.
std::vector<float> valuesNear(const cv::Mat& map, const cv::Point2f& p, int reach) {
  const cv::Point nearest(cvRound(p.x), cvRound(p.y));
  const cv::Rect inside(0, 0, map.cols, map.rows);
  if (!inside.contains(nearest) || !(map.at<float>(nearest) > 0)) return {};
  std::vector<float> values;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const cv::Point pixel = nearest + cv::Point(x, y);
      if (x * x + y * y > reach * reach || !inside.contains(pixel)) continue;
      if (const float value = map.at<float>(pixel); value > 0) values.push_back(value);
    }
  }
  return values;
}

double distance(const Eigen::Vector2d& a, const cv::Point2f& b) { return std::hypot(a.x() - b.x, a.y() - b.y); }

double degrees(double cosine) { return std::acos(std::min(1.0, std::max(-1.0, cosine))) * 180.0 / M_PI; }

/// Standard deviation along the worst axis.
double worst(const Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

std::optional<bool> within(double distance, double pose_noise_px) {
  const double limit = std::hypot(kCorrectWithin, kDeviations * pose_noise_px);
  return limit > kLoosestLabel ? std::nullopt : std::optional<bool>(distance < limit);
}

}  // namespace

TruthNoise defaultTruthNoise(const std::string& path) {
  std::string name = setName(path);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const KindOfTruth& kind : kKinds) {
    if (name.find(kind.word) != std::string::npos) return kind.noise;
  }
  return defaultTruthNoise(fs::exists(fs::path(kittiRigOf(path).value_or(path)) / "poses.txt") ? "kitti" : "tum");
}

ClockStep clockStep(const Dataset& dataset, const DatasetPair& pair, double clock) {
  ClockStep step;
  if (clock == 0) return step;
  const auto sooner = motion(dataset, pair, -clock), later = motion(dataset, pair, clock);
  if (!sooner || !later) return step;
  step.rotation = 0.5 * rotationVector(later->linear() * sooner->linear().transpose());
  step.translation = 0.5 * (later->translation() - sooner->translation());
  return step;
}

PairNoise::PairNoise(const TruthNoise& noise, const ClockStep& step, const Isometry3d& truth)
    : rotation(noise.rotation * noise.rotation * Matrix3d::Identity()),
      translation(noise.translation * noise.translation * Matrix3d::Identity()) {
  rotation += step.rotation * step.rotation.transpose();
  translation += step.translation * step.translation.transpose();
  rotation += byRotation(noise.alignment, rotationVector(truth.linear()));
  translation += byRotation(noise.alignment, truth.translation());
}

bool hasMoved(double baseline, const TruthNoise& noise) {
  return baseline > kRounding && baseline >= kMovedDeviations * noise.translation;
}

PoseError poseError(const Isometry3d& truth, const Matrix3d& R, const Vector3d& t) {
  constexpr double kZeroLength = 1e-12;  // a translation this short has no direction
  const double length = t.norm(), true_length = truth.translation().norm();
  return {degrees(((truth.linear().transpose() * R).trace() - 1) / 2),
          length < kZeroLength ? 90.0 : degrees(t.dot(truth.translation()) / (length * true_length + 1e-15))};
}

PairTruth::PairTruth(const Dataset& dataset, const DatasetPair& pair, const Camera& camera, const TruthNoise& noise)
    : pair_(pair), camera_(camera), K_inverse_(camera.K().inverse()), noise_(noise) {
  const auto& reference = dataset.frames()[static_cast<size_t>(pair.reference)];
  const auto& current = dataset.frames()[static_cast<size_t>(pair.current)];
  disparity_ = dataset.disparity(pair);
  if (!reference.pose || !current.pose) return;
  // The general inverse: printed rotations are orthonormal to their last digit only.
  current_in_reference_ = Isometry3d(reference.pose->matrix().inverse() * current.pose->matrix());
  pair_noise_ = PairNoise(noise, clockStep(dataset, pair, noise.clock), *current_in_reference_);
  if (!camera.calibrated()) return;
  rotation_px_ = worst(pair_noise_.rotation) * camera.meanFocalLength();
  translation_sigma_ = worst(pair_noise_.translation);
  const Vector3d t = current_in_reference_->translation();
  essential_ = crossMatrix(t / std::max(t.norm(), 1e-12)) * current_in_reference_->linear();
  depth_ = dataset.depth(pair.reference);
}

double PairTruth::epipolarDistance(const cv::Point2f& reference, const cv::Point2f& current) const {
  if (pair_.fundamental) {
    return symmetricDistance(pair_.fundamental->transpose(), homogeneous(reference), homogeneous(current));
  }
  return camera_.meanFocalLength() * symmetricDistance(*essential_,
                                                       K_inverse_ * homogeneous(camera_.undistort(reference)),
                                                       K_inverse_ * homogeneous(camera_.undistort(current)));
}

std::optional<double> PairTruth::transferDistance(const cv::Point2f& reference, const cv::Point2f& current,
                                                  int reach) const {
  if (pair_.homography) return distance((*pair_.homography * homogeneous(reference)).hnormalized(), current);
  std::optional<double> least;
  for (const float value : valuesNear(disparity_.empty() ? depth_ : disparity_, reference, reach)) {
    double candidate = 0;
    if (!disparity_.empty()) {
      candidate = distance({reference.x - static_cast<double>(value), reference.y}, current);
    } else {
      const Matrix3d K = camera_.K();
      const Vector3d point = K_inverse_ * homogeneous(camera_.undistort(reference)) * static_cast<double>(value);
      const Vector3d seen = current_in_reference_->inverse() * point;
      if (seen.z() <= 0) continue;
      candidate = distance((K * seen).hnormalized(), camera_.undistort(current));
    }
    if (!least || candidate <= *least) least = candidate;
  }
  return least;
}

/// Displacement of a match against the true rotation alone, pixels.
double PairTruth::parallax(const cv::Point2f& reference, const cv::Point2f& current) const {
  const Matrix3d R = current_in_reference_->linear().transpose();
  const Vector3d rotated = camera_.K() * R * K_inverse_ * homogeneous(camera_.undistort(reference));
  if (rotated.z() <= 0) return kLoosestLabel;
  return (rotated - rotated.z() * homogeneous(camera_.undistort(current))).head<2>().norm() / rotated.z();
}

std::optional<bool> PairTruth::label(const cv::Point2f& reference, const cv::Point2f& current) const {
  const std::optional<double> distance = hasTransfer() ? transferDistance(reference, current, kReach) : std::nullopt;
  if (distance) return within(*distance, rotation_px_);
  if (!current_in_reference_ || !camera_.calibrated()) {
    return hasEpipolar() ? within(epipolarDistance(reference, current), 0) : std::nullopt;
  }
  const double baseline = current_in_reference_->translation().norm(), off = parallax(reference, current);
  if (hasMoved(baseline, noise_)) {
    return within(epipolarDistance(reference, current), std::hypot(rotation_px_, translation_sigma_ / baseline * off));
  }
  return within(off, std::hypot(rotation_px_, (baseline + translation_sigma_) / kNearest * camera_.meanFocalLength()));
}

}  // namespace gms_ransac
