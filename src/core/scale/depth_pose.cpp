#include "scale/depth_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "gms_ransac/point_pairs.h"
#include "two_view/pose_model.h"
#include "two_view/sigma_by_octave.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
// Unknowns: the step of t, the rotation vector w, then three of the sensor (JointMotion).
constexpr int kPose = 6, kSensor = 3, kUnknowns = kPose + kSensor;
using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Column = Eigen::Matrix<double, kUnknowns, 1>;

constexpr int kMinimumSupport = 8;
// The key frame is the reference of this pair as soon as fewer of its points are seen: as a share, and a number.
constexpr double kStillSeen = 1. / 3;
constexpr double kLeastStillSeen = 30;
constexpr int kCloseStart = 2;  ///< iteration that a refinement begins with whose start is known to a deviation or two
constexpr int kIterations = 15;
constexpr double kConverged = 0.01;  // square of the last step by the covariance: a tenth of a standard deviation.
// Geman-McClure's loss bends where the squared residual over its freedom exceeds this. Where the residuals exceed the
// noise (a rolling shutter, depth of another moment) it bends at this many times the typical one. The first steps have
// a loss that is wider by kWide, half of that, and so on.
constexpr double kLoss = 4, kWide = 4;
constexpr double kTypicalSquare = 0.7;  ///< median of chi2 over its freedom, two degrees
constexpr double kLeastBend = 0.1;      ///< of the loss, mean second derivative over the weight; 0.75 on KITTI and TUM
// Depth beyond this share of difference between the four pixels around a point lies on a rim, relative.
constexpr double kRim = 0.05;
// Least standard deviation of a keypoint, pixels: exact points have none.
constexpr double kLeastSigma = 0.05;
// Standard deviation of the inverse depth, 1/m: of a Kinect that moves (0.4 px of its disparity: neighbouring pixels
// err together, and depth is of another moment than colour), and if it is not known.
constexpr double kDepthImageSigma = 0.01, kNoDepthSigma = 1;
// Prior standard deviation of the row rotation, radians: half a degree to one degree on a hand-held Kinect.
constexpr double kRowRotationSigma = 3.14159265358979323846 / 180;
// Standard deviation of a disparity, pixels: its patches are aligned, so it does not share the noise of the keypoint.
constexpr double kDisparitySigma = 0.2;
// Prior standard deviation of the disparity that the calibration of two cameras leaves, pixels, and of its growth over
// x = 1 and y = 1. KITTI's rectified images have 0.15 (06) and 1 (01): ignored, it makes the translation 0.6 and 10 %
// too long. Pairs measure it to 0.1. With 0.5 in place of 1, 01 is 1 % longer.
constexpr double kDisparityErrorSigma = 1;
constexpr double kNearest = 0.05;  // least depth in the current camera, as a share of that in the reference

/// Depth in the frame of `pose` of a point that is seen at its end; 0: not known.
double depthIn(const RelativePose& pose, const Vector3d& seen) {
  if (!(seen.z() > 0)) return 0;
  const Vector3d ray(seen.x(), seen.y(), 1);
  return (pose.R * ray / seen.z() + pose.t).z();
}

struct JointPoint {
  SeenPoint reference, current;
  Vector3d estimate = Vector3d::Zero();  ///< of `reference.value`, by all measurements
  int freedom = 1;  ///< of its residual: 1 without depth (the Sampson distance), 2 with depth in one image, 3 in both
  int32_t cell = 0;

  /// Estimate and freedom before the refinement. `depth`: in the reference where neither image shows it; 0: not known.
  void begin(const RelativePose& pose, double depth) {
    freedom = 1 + static_cast<int>(reference.has_depth) + static_cast<int>(current.has_depth);
    if (!reference.has_depth) {
      if (current.has_depth) depth = depthIn(pose, current.value);
      reference.value.z() = depth > 0 ? 1 / depth : 0;
    }
    estimate = reference.value;
  }
};

/// Motion, and what a sensor adds to it.
struct JointMotion {
  RelativePose pose;  ///< of the middle rows
  bool two_cameras;
  /// Two cameras: what calibration leaves of the inverse depths, to be added to each measured one: 1/m, and its growth
  /// with x (focal lengths that differ) and y (a camera rolled against the other).
  /// A depth camera: rotation vector, current minus reference, from the top row to the bottom. If the rotation during
  /// the readout of a rolling shutter differs between the images, the difference grows with the row; without it in the
  /// model it would be taken for translation.
  Vector3d sensor = Vector3d::Zero();

  void move(const Column& step) {
    pose.t += step.head<3>();
    pose.R = rotationFromVector(step.segment<3>(3)) * pose.R;
    sensor += step.tail<kSensor>();
  }
};

/// A point carried from the reference to the current image, less what is seen there, to first order.
struct JointResidual {
  Vector3d value;
  Eigen::Matrix<double, 3, kUnknowns> derivative;
  Matrix3d information;  ///< inverse of its covariance
  Matrix3d gain;         ///< step of the estimate over the residual
  double squared = -1;   ///< by its covariance; negative: the point does not take part
};

double depthAt(const cv::Mat& depth, const cv::Point2f& pixel) {
  if (!(pixel.x >= 0 && pixel.x < depth.cols - 1 && pixel.y >= 0 && pixel.y < depth.rows - 1)) return 0;
  const int x = static_cast<int>(pixel.x), y = static_cast<int>(pixel.y);
  const float z[4] = {depth.at<float>(y, x), depth.at<float>(y, x + 1), depth.at<float>(y + 1, x),
                      depth.at<float>(y + 1, x + 1)};
  const auto [low, high] = std::minmax_element(z, z + 4);
  for (float value : z) {
    if (!(value > 0) || !std::isfinite(value)) return 0;
  }
  if (*high - *low > kRim * *low) return 0;
  const double a = pixel.x - x, b = pixel.y - y;
  const double top = (1 - a) / z[0] + a / z[1], bottom = (1 - a) / z[2] + a / z[3];
  return 1 / ((1 - b) * top + b * bottom);
}

/// `sigma`: of a keypoint, at depth 1; `pixel`: the same of a pixel.
SeenPoint seenAt(double x, double y, double depth, double sigma, double pixel, double baseline, double row) {
  const double variance = sigma * sigma;
  double depth_sigma = kNoDepthSigma;
  if (depth > 0) depth_sigma = baseline > 0 ? kDisparitySigma * pixel / baseline : kDepthImageSigma;
  return {{x, y, depth > 0 ? 1 / depth : 0}, {variance, variance, depth_sigma * depth_sigma}, depth > 0, row};
}

/// Weighted median of metric over triangulated depth, whose ratio has a standard deviation that grows with depth.
double startingLength(std::vector<std::pair<double, double>> ratios) {
  double total = 0, sum = 0;
  for (const auto& [ratio, weight] : ratios) total += weight;
  std::sort(ratios.begin(), ratios.end());
  for (const auto& [ratio, weight] : ratios) {
    sum += weight;
    if (sum >= total / 2) return ratio;
  }
  return 0;
}

/// Factors of JointMotion::sensor in the error of an inverse depth.
Eigen::RowVector3d disparityError(const SeenPoint& seen) { return {1, seen.value.x(), seen.value.y()}; }

JointResidual residualOf(const JointPoint& p, const JointMotion& motion) {
  JointResidual result;
  const RelativePose& pose = motion.pose;
  const Vector3d ray(p.estimate.x(), p.estimate.y(), 1);
  const double inverse_depth = p.estimate.z();
  const Matrix3d rotation = pose.R.transpose();
  // The point over its depth in the reference, in the reference and in the current camera.
  Vector3d moved = ray - inverse_depth * pose.t, there = rotation * moved;
  auto by_sensor = result.derivative.rightCols<kSensor>();
  if (!motion.two_cameras) {
    // Half the row rotation belongs to either image, with opposite signs, to first order.
    const Vector3d half_rotation = -0.5 * motion.sensor;
    moved += p.reference.row * half_rotation.cross(ray);
    const Vector3d rotated = rotation * moved;
    there = rotated + p.current.row * half_rotation.cross(rotated);
    by_sensor = 0.5 * (p.reference.row * rotation * crossMatrix(ray) + p.current.row * crossMatrix(rotated));
  }
  if (!(there.z() > kNearest)) return result;
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
    by_sensor = (projection * by_sensor).eval();
  } else {
    by_sensor.setZero();
    if (p.reference.has_depth) by_sensor = by_point.col(2) * disparityError(p.reference);
    if (p.current.has_depth) by_sensor.row(2) -= disparityError(p.current);
    result.value += by_sensor * motion.sensor;
  }
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
  /// Moves the estimates of the points. `sensor_sigma`: prior standard deviation of each unknown of the sensor.
  JointRefinement(std::vector<JointPoint>& points, const JointMotion& start, double sensor_sigma)
      : points_(points),
        sensor_information_(1 / (sensor_sigma * sensor_sigma)),
        motion_(start),
        residuals_(points_.size()) {}

  /// False where there is no solution. The covariance of `pose` includes the uncertainty of the other unknowns.
  /// `first`: iteration to begin with; the later, the closer the start is thought to be.
  bool run(RelativePose& pose, int first = 0) {
    for (int i = first; i < kIterations; ++i) {
      loss_ = kLoss * typicalSquare() * std::max(1., kWide * std::pow(0.5, i));
      linearize();
      Column slope = gradient_;
      slope.tail<kSensor>() += sensor_information_ * motion_.sensor;
      const Column step = withPrior(curvature_).ldlt().solve(-slope);
      if (!step.allFinite()) return false;
      motion_.move(step);
      moveEstimates(step);
      if (i > 1 && -slope.dot(step) < kConverged) break;
    }
    motion_.pose.covariance = covariance();
    if (!motion_.pose.covariance.allFinite()) return false;
    pose = motion_.pose;
    return true;
  }

 private:
  struct Cell {
    Column gradient = Column::Zero();
    int count = 0;
  };

  Square withPrior(const Square& curvature) const {
    Square sum = curvature;
    sum.diagonal().tail<kSensor>().array() += sensor_information_;
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
      if (motion_.two_cameras && p.reference.has_depth) p.estimate.z() += disparityError(p.reference) * motion_.sensor;
    }
  }

  /// Huber's sandwich: the points of one cell err together (Liang & Zeger 1986), as the judgement has it.
  Eigen::Matrix<double, kPose, kPose> covariance() const {
    Square scatter = Square::Zero();
    int cells = 0;
    for (const Cell& cell : cells_) {
      scatter += cell.gradient * cell.gradient.transpose();
      cells += cell.count > 0;
    }
    scatter *= cells / std::max(1., static_cast<double>(cells - kPose));
    const Square inverse = withPrior(bend_ * curvature_).ldlt().solve(Square::Identity());
    return (inverse * withPrior(scatter) * inverse.transpose()).topLeftCorner<kPose, kPose>();
  }

  std::vector<JointPoint>& points_;
  double sensor_information_;  ///< on each unknown besides the pose
  JointMotion motion_;
  std::vector<JointResidual> residuals_;
  std::vector<double> squares_;
  double loss_ = kLoss;
  Square curvature_;
  Column gradient_;
  std::array<Cell, kSpreadGridSide * kSpreadGridSide> cells_;
  double bend_ = 1;  ///< mean second derivative of the loss over the weight
};

/// The motion by two independent measurements of it.
RelativePose fused(const RelativePose& a, const RelativePose& b) {
  const Matrix6d gain = a.covariance * (a.covariance + b.covariance).inverse();
  Vector6d difference;
  difference << b.t - a.t, rotationVector(b.R * a.R.transpose());
  const Vector6d step = gain * difference;
  RelativePose both = a;
  both.t += step.head<3>();
  both.R = rotationFromVector(step.tail<3>()) * a.R;
  both.covariance -= gain * a.covariance;
  return both;
}

/// Locates the current image in the key frame, by the motion `pose` of this pair and by the points of the key frame
/// that are still followed. `points`: of the pair, one for each of its columns.
void follow(const DepthPair& pair, const std::vector<JointPoint>& points, bool two_cameras, double sensor_sigma,
            const RelativePose& pose, KeyFrame& key) {
  const auto id = [&](size_t i) { return pair.track_ids[pair.points.match[i]]; };
  const auto earlier = [](const KeyFrame::Point& point, uint32_t track) { return point.track < track; };
  const RelativePose chain = chained(key.reference, pose);
  std::vector<JointPoint> still_seen;
  for (size_t i = 0; i < points.size(); ++i) {
    const auto found = std::lower_bound(key.points.begin(), key.points.end(), id(i), earlier);
    if (found == key.points.end() || found->track != id(i)) continue;
    still_seen.push_back(points[i]);
    still_seen.back().reference = found->seen;
    still_seen.back().begin(chain, depthIn(key.reference, points[i].reference.value));
  }
  RelativePose direct;
  const bool located = static_cast<double>(still_seen.size()) >=
                           std::max(kLeastStillSeen, kStillSeen * static_cast<double>(key.points.size())) &&
                       JointRefinement(still_seen, {chain, two_cameras}, sensor_sigma).run(direct, kCloseStart);
  if (located) {
    key.current = fused(chain, direct);
    key.is_reference = false;
    return;
  }
  key = KeyFrame();
  key.current = pose;
  for (size_t i = 0; i < points.size(); ++i) {
    if (id(i) != 0) key.points.push_back({id(i), points[i].reference});
  }
  std::sort(key.points.begin(), key.points.end(), [](const auto& a, const auto& b) { return a.track < b.track; });
}

}  // namespace

std::vector<float> keypointDepth(const Features& features, const cv::Mat& depth) {
  std::vector<float> column;
  if (depth.empty()) return column;
  column.reserve(features.keypoints.size());
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    column.push_back(static_cast<float>(depthAt(depth, keypoint.pt)));
  }
  return column;
}

ScaleEstimate poseFromKeypointDepth(const DepthPair& pair, RelativePose& pose, KeyFrame* key) {
  ScaleEstimate estimate;
  const double pixel = 1 / pair.camera.meanFocalLength();
  const SigmaByOctave sigma(pair.result.robust, pair.current.scale_factor);
  const auto noise = [&](const cv::KeyPoint& keypoint) {
    return pixel * std::max(kLeastSigma, static_cast<double>(sigma[keypoint.octave]));
  };
  const Triangulation& columns = pair.points;
  std::vector<JointPoint> points;
  points.reserve(static_cast<size_t>(columns.size()));
  std::vector<std::pair<double, double>> ratios;
  int matches = 0;
  for (int i = 0; i < columns.size(); ++i) {
    const Match& match = pair.result.matches[columns.match[i]];
    const cv::KeyPoint &r = pair.reference.keypoints[match.reference], &c = pair.current.keypoints[match.current];
    const double zr = pair.reference_depth.empty() ? 0 : pair.reference_depth[match.reference];
    const double zc = pair.current_depth.empty() ? 0 : pair.current_depth[match.current];
    const double row_r = r.pt.y / pair.reference.image_size.height - 0.5;
    const double row_c = c.pt.y / pair.current.image_size.height - 0.5;
    JointPoint p;
    p.reference = seenAt(columns.x_reference[i], columns.y_reference[i], zr, noise(r), pixel, pair.baseline, row_r);
    p.current = seenAt(columns.x_current[i], columns.y_current[i], zc, noise(c), pixel, pair.baseline, row_c);
    p.cell = spreadCell(c.pt, pair.current.image_size);
    points.push_back(p);
    matches += zr > 0 || zc > 0;
    if (zr > 0 && columns.valid[i]) ratios.emplace_back(zr / columns.depth_reference[i], 1 / zr);
    if (zc > 0 && columns.valid[i]) ratios.emplace_back(zc / columns.depth_current[i], 1 / zc);
  }
  if (matches < kMinimumSupport) return estimate;

  JointMotion start = {pair.result.robust.pose, pair.baseline > 0};
  const double length = startingLength(std::move(ratios));
  start.pose.t *= length;
  for (int i = 0; i < columns.size(); ++i) {
    points[i].begin(start.pose, columns.valid[i] ? length * columns.depth_reference[i] : 0);
  }
  const double sensor_sigma = start.two_cameras ? kDisparityErrorSigma * pixel / pair.baseline : kRowRotationSigma;
  if (!JointRefinement(points, start, sensor_sigma).run(pose)) return estimate;
  if (key) follow(pair, points, start.two_cameras, sensor_sigma, pose, *key);
  estimate.length = pose.t.norm();
  const Vector3d along = pose.t.normalized();
  estimate.relative_sigma =
      estimate.length > 0 ? std::sqrt(along.dot(pose.covariance.topLeftCorner<3, 3>() * along)) / estimate.length : 0;
  estimate.features = matches;
  return estimate;
}

}  // namespace gms_ransac
