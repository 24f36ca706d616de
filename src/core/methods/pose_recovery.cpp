#include "methods/pose_recovery.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "ransac/proposals.h"
#include "two_view/solvers/minimal_solvers.h"

namespace gms_ransac {

namespace {

/// A translation below this share of the plane's distance is none: at a focal length of 500 px it moves points by a
/// tenth of a pixel.
constexpr double kSmallestTranslation = 2e-4;

/// If the parallax is little more than the noise, the cost is a valley between rotating and moving aside. Gauss-Newton
/// steps along it are short, because they take the noise of the points for curvature: a step gains less than kEnough
/// long before the optimum (doc/measured/constants.md).
constexpr int kPoseIterations = 100;
constexpr float kEnoughInAValley = 1e-6f;

/// In the least-squares sense.
Eigen::Matrix3d nearestOrthogonal(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace

RecoveredPose PoseRecovery::recover(const PointPairs& pairs, const Camera& camera, const TwoViewPoints& points,
                                    const RobustResult& result, bool refine) {
  if (!camera.calibrated()) return {};
  propose(pairs, camera, result);
  const auto best = std::max_element(candidates_.begin(), candidates_.end(),
                                     [](const Motion& a, const Motion& b) { return a.in_front < b.in_front; });
  if (best == candidates_.end() || best->in_front == 0) return {};

  const bool normalized = points.type() == ModelType::kEssential;
  if (!normalized) normalized_.set(pairs, camera, ModelType::kEssential, options_.inlierThreshold(), 0);
  normalized_.countInto(points.view().evaluations);
  const TwoViewPoints& judged = normalized ? points : normalized_;
  if (best->pose.t.isZero()) return {&judge_.judgeRotation(judged, best->pose.R), {}};
  Explanation chosen = explain(judged.view(), best->pose, refine);
  if (options_.judge) weighAlternatives(judged.view(), best->in_front, refine, result.model_type, chosen);
  const RefinedPose& refined = judge_.refine(judged, refine, chosen.optimum);
  RecoveredPose recovered;
  if (refine && result.model_type == ModelType::kEssential) recovered.model = refined.pose.essential().normalized();
  recovered.judgement = &judge_.judge(refined, alternatives_, options_.mayRoll(pairs.shutter));
  return recovered;
}

void PoseRecovery::propose(const PointPairs& pairs, const Camera& camera, const RobustResult& result) {
  const Eigen::Matrix3d K = camera.K();
  collectInliers(pairs, K, result.inlier);
  candidates_.clear();
  if (result.model_type == ModelType::kHomography) return proposeFromHomography(result.model, K);
  proposeFromEssential(result.model_type == ModelType::kEssential ? result.model
                                                                  : Eigen::Matrix3d(K.transpose() * result.model * K));
}

void PoseRecovery::weighAlternatives(const PointColumnsView& points, int most_in_front, bool refine, ModelType type,
                                     Explanation& chosen) {
  const bool homography = type == ModelType::kHomography;
  const auto weigh = [&](const TwoViewPose& pose) {
    const Explanation other = explain(points, pose, refine);
    if ((refine || homography) && other.cost < chosen.cost) chosen = other;
    return other.optimum;
  };
  alternatives_.clear();
  findMotionStarts(kernels_, points, starts_);
  for (const TwoViewPose& start : starts_) {
    alternatives_.push_back({start});
    if (refine && type == ModelType::kFundamental) weigh(start);
  }
  if (homography) {
    for (const Motion& candidate : candidates_) {
      if (candidate.pose.t.isZero() || 2 * candidate.in_front < most_in_front) continue;
      alternatives_.push_back({weigh(candidate.pose), true});
    }
  } else if (const auto other = findOtherPlaneMotion({kernels_, points}, chosen.optimum, residuals_)) {
    alternatives_.push_back({chosen.optimum, true});
    alternatives_.push_back({weigh(*other), true});
  }
}

PoseRecovery::Explanation PoseRecovery::explain(const PointColumnsView& points, const TwoViewPose& pose,
                                                bool refine) const {
  const PoseModel model(kernels_, points);
  Explanation explanation = {pose, 0};
  if (refine) model.refine(kRobustLoss, kPoseIterations, explanation.optimum, kEnoughInAValley);
  HypothesisScore score;
  model.score(points, explanation.optimum, std::numeric_limits<float>::max(), score);
  explanation.cost = score.cost;
  return explanation;
}

void PoseRecovery::collectInliers(const PointPairs& pairs, const Eigen::Matrix3d& K,
                                  const std::vector<uint8_t>& inlier) {
  const Eigen::Matrix3d K_inverse = K.inverse();
  reference_.clear();
  current_.clear();
  for (size_t row = 0; row < inlier.size(); ++row) {
    if (!inlier[row]) continue;
    reference_.emplace_back(K_inverse * Eigen::Vector3d(pairs.x_reference[row], pairs.y_reference[row], 1));
    current_.emplace_back(K_inverse * Eigen::Vector3d(pairs.x_current[row], pairs.y_current[row], 1));
  }
}

void PoseRecovery::proposeFromEssential(const Eigen::Matrix3d& E) {
  // The closed form needs the constraints of an essential matrix, which a fundamental matrix between two calibrations
  // breaks by far and the root of a five-point polynomial by its rounding: take the nearest matrix that meets them.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * Eigen::Vector3d(1, 1, 0).asDiagonal() * svd.matrixV().transpose();
  const EssentialDecomposition parts = decomposeEssential(nearest);
  for (const Eigen::Matrix3d& R : {parts.R1, parts.R2}) {
    propose({R, parts.t});
    propose({R, -parts.t});
  }
}

void PoseRecovery::proposeFromHomography(const Eigen::Matrix3d& H, const Eigen::Matrix3d& K) {
  cv::Mat H_cv, K_cv;
  cv::eigen2cv(H, H_cv);
  cv::eigen2cv(K, K_cv);
  // Up to four motions, two of them once the points must lie in front (Faugeras & Lustman 1988; OpenCV computes them as
  // Malis & Vargas 2007).
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(H_cv, K_cv, rotations, translations, normals);
  for (size_t i = 0; i < rotations.size(); ++i) {
    TwoViewPose motion;
    cv::cv2eigen(rotations[i], motion.R);
    cv::cv2eigen(translations[i], motion.t);
    if (!motion.R.allFinite() || !motion.t.allFinite()) continue;
    motion.R = nearestOrthogonal(motion.R);  // OpenCV's has an error of 1e-3 if the homography is nearly a rotation
    if (!(motion.R.determinant() > 0)) continue;  // and is a mirror if it is nearly singular
    const double length = motion.t.norm();
    motion.t = length > kSmallestTranslation ? Eigen::Vector3d(motion.t / length) : Eigen::Vector3d::Zero();
    propose(motion);
  }
}

void PoseRecovery::propose(const TwoViewPose& pose) { candidates_.push_back({pose, countInFront(pose)}); }

int PoseRecovery::countInFront(const TwoViewPose& motion) const {
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
