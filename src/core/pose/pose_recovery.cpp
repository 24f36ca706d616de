#include "pose/pose_recovery.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "robust/fast/pose_uncertainty.h"
#include "robust/inlier_counter.h"
#include "robust/solvers/essential_5pt.h"

namespace gms_ransac {

namespace {

/// A translation below this share of the plane's distance is none: at a focal length of 500 px it moves points by a
/// tenth of a pixel.
constexpr double kSmallestTranslation = 2e-4;

/// In the least-squares sense.
Eigen::Matrix3d nearestOrthogonal(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace

void PoseRecovery::recover(const PointPairs& pairs, const Camera& camera, double threshold_px, RobustResult& result) {
  if (!camera.calibrated()) return;
  const Eigen::Matrix3d K = camera.K();
  collectInliers(pairs, K, result.inlier);
  candidates_.clear();
  if (result.model_type == ModelType::kHomography) {
    proposeFromHomography(result.model, K);
  } else {
    proposeFromEssential(
        result.model_type == ModelType::kEssential ? result.model : Eigen::Matrix3d(K.transpose() * result.model * K));
  }
  const Motion* best = nullptr;
  int most = 0;
  for (const Motion& candidate : candidates_) {
    const int in_front = countInFront(candidate);
    if (in_front <= most) continue;
    most = in_front;
    best = &candidate;
  }
  if (best == nullptr) return;
  result.pose_found = true;
  judgeParallax(*best, camera.meanFocalLength(), threshold_px, result);
}

bool PoseRecovery::refineEssential(const PointPairs& pairs, const Camera& camera, double threshold_px,
                                   RobustResult& result) {
  if (result.model_type != ModelType::kEssential || !result.pose_found) return false;
  all_matches_.resize(static_cast<size_t>(pairs.size()));
  for (size_t i = 0; i < all_matches_.size(); ++i) all_matches_[i] = pairs.hasPlaces(i);
  collectInliers(pairs, camera.K(), all_matches_);
  const PoseModel model(*kernels_, fillColumns(threshold_px / camera.meanFocalLength()));
  TwoViewPose pose = {result.pose.R.transpose(), -(result.pose.R.transpose() * result.pose.t)};
  result.point_evaluations +=
      static_cast<int64_t>(pairs.size()) * model.refine(kRefinementLoss, kRefinementIterations, pose, kEnough);
  result.model = pose.essential().normalized();
  return true;
}

PointColumnsView PoseRecovery::fillColumns(double threshold) {
  columns_.resize(static_cast<int>(reference_.size()));
  for (size_t i = 0; i < reference_.size(); ++i) {
    columns_.x1()[i] = static_cast<float>(reference_[i].x());
    columns_.y1()[i] = static_cast<float>(reference_[i].y());
    columns_.x2()[i] = static_cast<float>(current_[i].x());
    columns_.y2()[i] = static_cast<float>(current_[i].y());
    columns_.weight()[i] = static_cast<float>(1 / (threshold * threshold));
  }
  return columns_.view();
}

void PoseRecovery::judgeParallax(const Motion& motion, double unit_px, double threshold_px, RobustResult& result) {
  const PointColumnsView points = fillColumns(threshold_px / unit_px);
  const PoseModel model(*kernels_, points);
  const TwoViewPose pose = {motion.R, motion.t};
  // A model fitted to rotating views trades rotation for translation, so its own rotation leaves a displacement that
  // is no parallax. The best rotation alone tells.
  all_inliers_.assign(static_cast<size_t>(points.size), 0.f);
  residuals_.resize(static_cast<size_t>(points.size));
  const RotationOnly rotation =
      fitRotationOnly(model, points, pose, all_inliers_, residuals_, result.point_evaluations);
  result.median_parallax_px = unit_px * rotation.median_residual;
  result.translation_observable = !motion.t.isZero() && result.median_parallax_px > kObservableParallaxPx;
  result.pose = fromReferenceToCurrent(result.translation_observable ? motion.R : rotation.R, motion.t);
  result.pose.covariance =
      result.translation_observable ? poseCovariance(model, points.count, pose) : rotation.covariance;
}

void PoseRecovery::collectInliers(const PointPairs& pairs, const Eigen::Matrix3d& K,
                                  const std::vector<uint8_t>& inlier) {
  const Eigen::Matrix3d K_inverse = K.inverse();
  reference_.clear();
  current_.clear();
  for (size_t i = 0; i < inlier.size(); ++i) {
    if (!inlier[i]) continue;
    reference_.emplace_back(K_inverse * Eigen::Vector3d(pairs.x_reference[i], pairs.y_reference[i], 1));
    current_.emplace_back(K_inverse * Eigen::Vector3d(pairs.x_current[i], pairs.y_current[i], 1));
  }
}

void PoseRecovery::proposeFromEssential(const Eigen::Matrix3d& E) {
  // The closed form needs the constraints of an essential matrix, which a fundamental matrix between two calibrations
  // breaks by far and the root of a five-point polynomial by its rounding: take the nearest matrix that meets them.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * Eigen::Vector3d(1, 1, 0).asDiagonal() * svd.matrixV().transpose();
  const EssentialDecomposition parts = decomposeEssential(nearest);
  for (const Eigen::Matrix3d& R : {parts.R1, parts.R2}) {
    candidates_.push_back({R, parts.t});
    candidates_.push_back({R, -parts.t});
  }
}

void PoseRecovery::proposeFromHomography(const Eigen::Matrix3d& H, const Eigen::Matrix3d& K) {
  cv::Mat H_cv, K_cv;
  cv::eigen2cv(H, H_cv);
  cv::eigen2cv(K, K_cv);
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(H_cv, K_cv, rotations, translations, normals);
  for (size_t i = 0; i < rotations.size(); ++i) {
    Motion motion;
    cv::cv2eigen(rotations[i], motion.R);
    cv::cv2eigen(translations[i], motion.t);
    if (!motion.R.allFinite() || !motion.t.allFinite()) continue;
    motion.R = nearestOrthogonal(motion.R);  // OpenCV's is off by 1e-3 when the homography is nearly a rotation
    const double length = motion.t.norm();
    motion.t = length > kSmallestTranslation ? Eigen::Vector3d(motion.t / length) : Eigen::Vector3d::Zero();
    candidates_.push_back(motion);
  }
}

int PoseRecovery::countInFront(const Motion& motion) const {
  int count = 0;
  for (size_t i = 0; i < reference_.size(); ++i) {
    // z_current x_current = z_reference R x_reference + t, each depth by crossing the other ray away.
    const Eigen::Vector3d rotated = motion.R * reference_[i];
    const Eigen::Vector3d normal = rotated.cross(current_[i]);
    const double z_reference = normal.dot(current_[i].cross(motion.t));
    const double z_current = normal.dot(rotated.cross(motion.t));
    count += motion.t.isZero() ? rotated.z() > 0 : z_reference > 0 && z_current > 0;
  }
  return count;
}

}  // namespace gms_ransac
