#include "run/pair_truth.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

/// Larger distance of p from the line M q and of q from the line M^T p, for p^T M q = 0.
double symmetricDistance(const Eigen::Matrix3d& M, const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  const Eigen::Vector3d line_p = M * q, line_q = M.transpose() * p;
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

}  // namespace

PoseError poseError(const Eigen::Isometry3d& truth, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  constexpr double kZeroLength = 1e-12;  // a translation this short has no direction
  const double length = t.norm(), true_length = truth.translation().norm();
  return {degrees(((truth.linear().transpose() * R).trace() - 1) / 2),
          length < kZeroLength ? 90.0 : degrees(t.dot(truth.translation()) / (length * true_length + 1e-15))};
}

PairTruth::PairTruth(const Dataset& dataset, const DatasetPair& pair, const Camera& camera)
    : pair_(pair), camera_(camera) {
  const auto& reference = dataset.frames()[static_cast<size_t>(pair.reference)];
  const auto& current = dataset.frames()[static_cast<size_t>(pair.current)];
  disparity_ = dataset.disparity(pair);
  if (!reference.pose || !current.pose) return;
  // The general inverse: printed rotations are orthonormal to their last digit only.
  current_in_reference_ = Eigen::Isometry3d(reference.pose->matrix().inverse() * current.pose->matrix());
  if (!camera.calibrated()) return;
  const Eigen::Vector3d t = current_in_reference_->translation();
  essential_ = crossMatrix(t / std::max(t.norm(), 1e-12)) * current_in_reference_->linear();
  depth_ = dataset.depth(pair.reference);
}

double PairTruth::epipolarDistance(const cv::Point2f& reference, const cv::Point2f& current) const {
  if (pair_.fundamental) {
    return symmetricDistance(pair_.fundamental->transpose(), homogeneous(reference), homogeneous(current));
  }
  const Eigen::Matrix3d K_inverse = camera_.K().inverse();
  return camera_.meanFocalLength() * symmetricDistance(*essential_,
                                                       K_inverse * homogeneous(camera_.undistort(reference)),
                                                       K_inverse * homogeneous(camera_.undistort(current)));
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
      const Eigen::Matrix3d K = camera_.K();
      const Eigen::Vector3d point =
          K.inverse() * homogeneous(camera_.undistort(reference)) * static_cast<double>(value);
      const Eigen::Vector3d seen = current_in_reference_->inverse() * point;
      if (seen.z() <= 0) continue;
      candidate = distance((K * seen).hnormalized(), camera_.undistort(current));
    }
    if (!least || candidate <= *least) least = candidate;
  }
  return least;
}

}  // namespace gms_ransac
