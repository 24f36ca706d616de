#include "scale/joint_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "gms_ransac/point_pairs.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;
// Unknowns: the step of t, the rotation vector w, then four of the sensor (JointMotion).
constexpr int kPose = 6, kSensor = 4, kUnknowns = kPose + kSensor;
using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Column = Eigen::Matrix<double, kUnknowns, 1>;

constexpr int kCloseStart = 2;  ///< iteration that a refinement begins with whose start is known to a deviation or two
constexpr int kGaussNewtonSteps = 15;
constexpr double kConverged = 0.01;  // square of the last step by the covariance: a tenth of a standard deviation.
// Geman-McClure's loss bends where the squared residual over its freedom exceeds this. Where the residuals exceed the
// noise (a rolling shutter, depth of another moment) it bends at this many times the typical one. The first steps have
// a loss that is wider by kWide, half of that, and so on.
constexpr double kLoss = 4, kWide = 4;
constexpr double kTypicalSquare = 0.7;  ///< median of chi2 over its freedom, two degrees
constexpr double kLeastBend = 0.1;      ///< of the loss, mean second derivative over the weight; 0.75 on KITTI and TUM
constexpr double kNearestShare = 0.05;  // least depth in the current camera, as a share of that in the reference

void move(const Column& step, JointMotion& motion) {
  motion.pose.t += step.head<3>();
  motion.pose.R = rotationFromVector(step.segment<3>(3)) * motion.pose.R;
  motion.sensor += step.tail<kSensor>();
}

/// A point carried from the reference to the current image, less what is seen there, to first order.
struct JointResidual {
  Vector3d value;
  Eigen::Matrix<double, 3, kUnknowns> derivative;
  Matrix3d information;  ///< inverse of its covariance
  Matrix3d gain;         ///< step of the estimate over the residual
  double squared = -1;   ///< by its covariance; negative: the point does not take part
};

/// Factors of JointMotion::sensor in the error of an inverse depth.
Eigen::RowVector4d errorOfDepth(const SeenPoint& seen, const JointMotion& motion) {
  if (!motion.two_cameras) return {0, 0, 0, 1};
  const double x = seen.value.x(), y = seen.value.y();
  return {1, x, y, x * x + y * y};
}

JointResidual residualOf(const JointPoint& p, const JointMotion& motion) {
  JointResidual result;
  const RelativePose& pose = motion.pose;
  const Vector3d ray(p.estimate.x(), p.estimate.y(), 1);
  const double inverse_depth = p.estimate.z();
  const Matrix3d rotation = pose.R.transpose();
  // The point over its depth in the reference, in the reference and in the current camera.
  Vector3d moved = ray - inverse_depth * pose.t, there = rotation * moved;
  auto by_sensor = result.derivative.rightCols<kSensor>();
  auto by_rotation = by_sensor.leftCols<3>();
  by_sensor.setZero();
  if (!motion.two_cameras) {
    // Half the row rotation belongs to either image, with opposite signs, to first order.
    const Vector3d half_rotation = -0.5 * motion.sensor.head<3>();
    moved += p.reference.row * half_rotation.cross(ray);
    const Vector3d rotated = rotation * moved;
    there = rotated + p.current.row * half_rotation.cross(rotated);
    by_rotation = 0.5 * (p.reference.row * rotation * crossMatrix(ray) + p.current.row * crossMatrix(rotated));
  }
  if (!(there.z() > kNearestShare)) return result;
  const double s = 1 / there.z();
  const Vector3d seen(there.x() * s, there.y() * s, inverse_depth * s);
  Matrix3d projection = s * Matrix3d::Identity();
  projection.col(2) = -s * seen;
  const Matrix3d by_moved = projection * rotation;
  Matrix3d by_point;
  by_point << by_moved.col(0), by_moved.col(1), -by_moved * pose.t;
  by_point(2, 2) += s;
  result.derivative.leftCols<3>() = -inverse_depth * by_moved;
  for (int i = 0; i < 3; ++i) {
    result.derivative.block<1, 3>(i, 3) = by_moved.row(i).cross(moved);
  }

  result.value = seen - p.current.value + by_point * (p.reference.value - p.estimate);
  if (!motion.two_cameras) {
    by_rotation = (projection * by_rotation).eval();
  }
  Eigen::Matrix<double, 3, kSensor> by_error = Eigen::Matrix<double, 3, kSensor>::Zero();
  if (p.reference.has_depth) by_error = by_point.col(2) * errorOfDepth(p.reference, motion);
  if (p.current.has_depth) by_error.row(2) -= errorOfDepth(p.current, motion);
  by_sensor += by_error;
  result.value += by_error * motion.sensor;
  const Matrix3d spread = by_point * p.reference.variance.asDiagonal();
  Matrix3d covariance = spread * by_point.transpose();
  covariance.diagonal() += p.current.variance;
  if (p.current.has_depth) {
    result.information = covariance.inverse();
  } else {
    result.information.setZero();
    result.information.topLeftCorner<2, 2>() = Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()).inverse();
  }
  result.gain = spread.transpose() * result.information;
  const double squared = result.value.dot(result.information * result.value);
  if (squared >= 0 && std::isfinite(squared)) result.squared = squared;
  return result;
}

/// The refinement of one pair: Gauss-Newton over the motion and the points, which are eliminated.
class JointRefinement {
 public:
  /// Moves the estimates of the points.
  JointRefinement(std::vector<JointPoint>& points, const JointMotion& start, const SensorPrior& prior)
      : points_(points), prior_(prior), motion_(start), residuals_(points_.size()) {
    motion_.sensor = prior.mean;
  }

  /// `first`: iteration to begin with; the later, the closer the start is thought to be.
  std::optional<JointEstimate> run(int first) {
    for (int i = first; i < kGaussNewtonSteps; ++i) {
      loss_ = kLoss * typicalSquare() * std::max(1., kWide * std::pow(0.5, i));
      linearize();
      Column slope = gradient_;
      slope.tail<kSensor>() += prior_.information * (motion_.sensor - prior_.mean);
      const Column step = withPrior(curvature_).ldlt().solve(-slope);
      if (!step.allFinite()) return std::nullopt;
      move(step, motion_);
      moveEstimates(step);
      if (i > 1 && -slope.dot(step) < kConverged) break;
    }
    const JointEstimate answer = estimate();
    if (!answer.pose.covariance.allFinite() || !answer.shared.allFinite()) return std::nullopt;
    return answer;
  }

 private:
  struct Cell {
    Column gradient = Column::Zero();
    int count = 0;
  };

  Square withPrior(const Square& curvature) const {
    Square sum = curvature;
    sum.bottomRightCorner<kSensor, kSensor>() += prior_.information;
    return sum;
  }

  /// Computes the residuals; returns how many times their squares exceed the noise, 1 or more.
  double typicalSquare() {
    squares_.clear();
    for (size_t i = 0; i < points_.size(); ++i) {
      residuals_[i] = residualOf(points_[i], motion_);
      if (residuals_[i].squared >= 0) squares_.push_back(residuals_[i].squared / points_[i].freedom);
    }
    if (squares_.empty()) return 1;
    const auto middle = squares_.begin() + static_cast<std::ptrdiff_t>(squares_.size() / 2);
    std::nth_element(squares_.begin(), middle, squares_.end());
    return std::max(1., *middle / kTypicalSquare);
  }

  /// Normal equations of half the loss.
  void linearize() {
    curvature_.setZero();
    gradient_.setZero();
    cells_.fill(Cell());
    double weights = 0, bends = 0;
    for (size_t i = 0; i < points_.size(); ++i) {
      const JointResidual& r = residuals_[i];
      if (r.squared < 0) continue;
      const double ratio = r.squared / (loss_ * points_[i].freedom), weight = 1 / ((1 + ratio) * (1 + ratio));
      weights += weight;
      bends += weight * (1 - 4. / points_[i].freedom * ratio / (1 + ratio));
      // Coefficient by coefficient: products of this size otherwise go through Eigen's blocked kernel, which is slower.
      const Eigen::Matrix<double, kUnknowns, 3> weighted = weight * r.derivative.transpose().lazyProduct(r.information);
      curvature_.triangularView<Eigen::Lower>() += weighted.lazyProduct(r.derivative);
      Cell& cell = cells_.at(static_cast<size_t>(points_[i].cell));
      cell.gradient += weighted.lazyProduct(r.value);
      ++cell.count;
    }
    curvature_.triangularView<Eigen::StrictlyUpper>() = curvature_.transpose();
    for (const Cell& cell : cells_) gradient_ += cell.gradient;
    bend_ = weights > 0 ? std::max(kLeastBend, bends / weights) : 1;
  }

  void moveEstimates(const Column& step) {
    for (size_t i = 0; i < points_.size(); ++i) {
      JointPoint& p = points_[i];
      if (residuals_[i].squared < 0 || p.freedom == 1) continue;
      p.estimate = p.reference.value;
      if (residuals_[i].squared > loss_ * p.freedom) continue;  // it says nothing of this point
      p.estimate -= residuals_[i].gain * (residuals_[i].value + residuals_[i].derivative * step);
      if (p.reference.has_depth) p.estimate.z() += errorOfDepth(p.reference, motion_) * motion_.sensor;
    }
  }

  /// Huber's sandwich: the points of one cell err together (Liang & Zeger 1986), as the judgement has it.
  JointEstimate estimate() const {
    Square scatter = Square::Zero();
    int cells = 0;
    for (const Cell& cell : cells_) {
      scatter += cell.gradient * cell.gradient.transpose();
      cells += cell.count > 0;
    }
    scatter *= cells / std::max(1., static_cast<double>(cells - kPose));
    const Square curvature = bend_ * curvature_, inverse = withPrior(curvature).ldlt().solve(Square::Identity());
    JointEstimate answer;
    answer.pose = motion_.pose;
    answer.pose.covariance = (inverse * scatter * inverse.transpose()).topLeftCorner<kPose, kPose>();
    answer.shared = inverse.topRightCorner<kPose, kSensor>() * prior_.information.llt().matrixL();
    auto of_pair = answer.shared.leftCols(prior_.shared_from);
    answer.pose.covariance += of_pair * of_pair.transpose();
    of_pair.setZero();
    answer.sensor = evidence(curvature, scatter);
    return answer;
  }

  /// The pose is eliminated, which follows the sensor.
  SensorEvidence evidence(const Square& curvature, const Square& scatter) const {
    Eigen::Matrix<double, kUnknowns, kSensor> follow;
    follow << -curvature.topLeftCorner<kPose, kPose>().ldlt().solve(curvature.topRightCorner<kPose, kSensor>()),
        Matrix4d::Identity();
    const Matrix4d information = follow.transpose() * curvature.rightCols<kSensor>();
    const Vector4d score = information * motion_.sensor - follow.transpose() * gradient_;
    const Matrix4d gain = information * (follow.transpose() * scatter * follow).inverse();
    return {gain * score, gain * information};
  }

  std::vector<JointPoint>& points_;
  const SensorPrior& prior_;
  JointMotion motion_;
  std::vector<JointResidual> residuals_;
  std::vector<double> squares_;
  double loss_ = kLoss;
  Square curvature_;
  Column gradient_;
  std::array<Cell, kSpreadGridSide * kSpreadGridSide> cells_;
  double bend_ = 1;  ///< mean second derivative of the loss over the weight
};

}  // namespace

double depthIn(const RelativePose& pose, const Vector3d& seen) {
  if (!(seen.z() > 0)) return 0;
  const Vector3d ray(seen.x(), seen.y(), 1);
  return (pose.R * ray / seen.z() + pose.t).z();
}

void JointPoint::begin(const RelativePose& pose, double depth) {
  freedom = 1 + static_cast<int>(reference.has_depth) + static_cast<int>(current.has_depth);
  if (!reference.has_depth) {
    if (current.has_depth) depth = depthIn(pose, current.value);
    reference.value.z() = depth > 0 ? 1 / depth : 0;
  }
  estimate = reference.value;
}

std::optional<JointEstimate> refineJointly(std::vector<JointPoint>& points, const JointMotion& start,
                                           const SensorPrior& prior, bool close) {
  return JointRefinement(points, start, prior).run(close ? kCloseStart : 0);
}

}  // namespace gms_ransac
