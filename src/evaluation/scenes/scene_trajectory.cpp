#include "scenes/scene_trajectory.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include <Eigen/SparseCholesky>

#include "datasets/dataset_text.h"
#include "support/validation.h"

namespace gms_ransac {

namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Knots per second, unless there are fewer poses: motion up to 10 Hz remains, and the noise of motion capture at 100
// Hz, which would be an acceleration of metres per second squared, is averaged.
constexpr double kKnotRate = 20;
// Weight of the penalty. KITTI's poses are met to 0.4 mm. TUM-VI's motion capture has holes of a second: at 1e-8 the
// curve swings to thousands of degrees per second there, at 1e-3 it rotates no faster than the hand.
constexpr double kStiffness = 1e-3;
constexpr double kRounding = 0.01;       // files have four digits and more
constexpr double kLargestRotation = 90;  // degrees from pose to pose: beyond it nobody knows which way it went
constexpr double kFloorBelow = 1;        // metres from the lowest camera down to the floor
constexpr double kBetweenPlaces = 0.01;  // seconds

const char kFormats[] =
    "a pose: stamp x y z qx qy qz qw (TUM), 12 numbers of a matrix (KITTI) or ns,x,y,z,qw,qx,qy,qz (EuRoC)";

/// World axes z up from those of KITTI's first camera: z forward becomes x, y down becomes -z.
const Quaterniond kUpFromCamera(0.5, -0.5, 0.5, -0.5);

enum class Format { kTum, kKitti, kEuroc };

Format formatOf(const std::string& file, const TextLine& line) {
  if (line.text.find(',') != std::string::npos) return Format::kEuroc;
  if (line.fields.size() == 12) return Format::kKitti;
  if (line.fields.size() == 8) return Format::kTum;
  failAt(file, line, std::string("expected ") + kFormats);
}

std::vector<std::string> splitCsv(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream words(text);
  return {std::istream_iterator<std::string>(words), {}};
}

Isometry3d poseAt(const std::string& file, const TextLine& line, const Vector3d& position,
                  const Quaterniond& rotation) {
  if (std::abs(rotation.norm() - 1) > kRounding) failAt(file, line, "the quaternion is not of unit length");
  return Eigen::Translation3d(position) * rotation.normalized();
}

StampedPose parsePose(const std::string& file, TextLine line, Format format) {
  constexpr double kNanoseconds = 1e-9;
  if (format == Format::kEuroc) {
    line.fields = splitCsv(line.text);  // pose, velocity and biases: the first eight count
    line.fields.resize(std::min<size_t>(line.fields.size(), 8));
  }
  const std::vector<double> v = numbersAt(file, line, 0, format == Format::kKitti ? 12 : 8, kFormats);
  if (format == Format::kTum) return {v[0], poseAt(file, line, {v[1], v[2], v[3]}, {v[7], v[4], v[5], v[6]})};
  if (format == Format::kEuroc)
    return {kNanoseconds * v[0], poseAt(file, line, {v[1], v[2], v[3]}, {v[4], v[5], v[6], v[7]})};
  Eigen::Matrix3d R;
  R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  if (!R.isUnitary(kRounding) || R.determinant() < 0) failAt(file, line, "the first three columns are no rotation");
  return {0, kUpFromCamera * poseAt(file, line, {v[3], v[7], v[11]}, Quaterniond(R))};
}

}  // namespace

void TrajectoryOptions::validate() const {
  requireInRange("pose_rate", pose_rate, 0.1, 1000.0);
  requireInRange("from", from, 0.0, 1e5);
  requireInRange("duration", duration, 0.0, 1e5);
  requireInRange("scale", scale, 1e-4, 1e4);
}

std::vector<StampedPose> readTrajectory(const TrajectoryOptions& options) {
  options.validate();
  const std::string& file = options.file;
  const std::vector<TextLine> lines = readLines(file);
  if (lines.empty()) throw DatasetError(file + ": has no poses");
  const Format format = formatOf(file, lines[0]);
  const bool of_imu = options.imu.value_or(format == Format::kEuroc);
  if (of_imu && !options.camera_in_imu) {
    throw DatasetError(file + ": has poses of an IMU; give --camera-in-imu, the place of the camera on it");
  }

  std::vector<StampedPose> poses;
  const double first = parsePose(file, lines[0], format).stamp;
  double last = first - 1;
  for (size_t i = 0; i < lines.size(); ++i) {
    StampedPose pose = parsePose(file, lines[i], format);
    if (format == Format::kKitti) pose.stamp = static_cast<double>(i) / options.pose_rate;
    if (pose.stamp == last) continue;  // TUM's files repeat a stamp here and there
    if (pose.stamp < last) failAt(file, lines[i], "the time stamps decrease");
    last = pose.stamp;
    const double seconds = pose.stamp - first - options.from;
    if (seconds < 0 || (options.duration > 0 && seconds > options.duration)) continue;
    pose.pose.translation() *= options.scale;
    if (of_imu) pose.pose = pose.pose * *options.camera_in_imu;
    if (!poses.empty()) {
      const Eigen::AngleAxisd rotation(poses.back().pose.linear().transpose() * pose.pose.linear());
      if (rotation.angle() > kLargestRotation * M_PI / 180)
        failAt(file, lines[i], "more than 90 degrees from the pose before: the way between them is not known");
    }
    poses.push_back(pose);
  }
  if (poses.size() < 2) {
    std::ostringstream sentence;
    sentence << file << ": fewer than two poses from " << options.from << " s on; the file has " << last - first
             << " s";
    throw DatasetError(sentence.str());
  }
  const StampedPose origin = poses.front();
  for (StampedPose& pose : poses) {
    pose.stamp -= origin.stamp;
    pose.pose.pretranslate(-origin.pose.translation());
  }
  return poses;
}

Trajectory::Trajectory(const std::vector<StampedPose>& poses) : begin_(poses.front().stamp) {
  const int count = static_cast<int>(poses.size());
  const double seconds = poses.back().stamp - begin_;
  const int intervals = std::max(1, static_cast<int>(std::min<double>(count - 1, std::ceil(kKnotRate * seconds))));
  spacing_ = seconds / intervals;
  const int points = intervals + kDegree;
  points_.resize(7, points);  // end() and basis() read their number

  std::vector<Eigen::Triplet<double>> weights;
  Eigen::Matrix<double, Eigen::Dynamic, 7> values(count + points - 3, 7);
  values.setZero();
  Quaterniond rotation = Quaterniond::Identity();
  for (int i = 0; i < count; ++i) {
    int first;
    const Basis basis = this->basis(poses[i].stamp, first);
    for (int k = 0; k <= kDegree; ++k) weights.emplace_back(i, first + k, basis[k]);
    Quaterniond next(poses[i].pose.linear());
    if (next.dot(rotation) < 0) next.coeffs() *= -1;  // the same rotation on the side of the one before
    rotation = next;
    values.row(i) << poses[i].pose.translation().transpose(), rotation.coeffs().transpose();
  }
  for (int j = 0; j < points - 3; ++j) {
    constexpr double kThirdDifference[] = {-1, 3, -3, 1};
    for (int k = 0; k < 4; ++k) weights.emplace_back(count + j, j + k, std::sqrt(kStiffness) * kThirdDifference[k]);
  }
  Eigen::SparseMatrix<double> A(values.rows(), points);
  A.setFromTriplets(weights.begin(), weights.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> normal_equations(A.transpose() * A);
  points_ = normal_equations.solve(A.transpose() * values).transpose();
}

Trajectory::Basis Trajectory::basis(double seconds, int& first) const {
  const double knots = (seconds - begin_) / spacing_;
  first = std::clamp(static_cast<int>(std::floor(knots)), 0, static_cast<int>(points_.cols()) - kDegree - 1);
  const double u = knots - first;
  Basis b = Basis::Unit(0);
  for (int degree = 1; degree <= kDegree; ++degree) {  // de Boor's recursion with uniform knots
    for (int k = degree; k >= 0; --k) {
      b[k] = ((k < degree ? (k + 1 - u) * b[k] : 0) + (k > 0 ? (u + degree - k) * b[k - 1] : 0)) / degree;
    }
  }
  return b;
}

Isometry3d Trajectory::pose(double seconds) const {
  int first;
  const Basis weights = basis(seconds, first);
  const Eigen::Matrix<double, 7, 1> value = points_.middleCols<kDegree + 1>(first) * weights;
  return Eigen::Translation3d(value.head<3>()) * Quaterniond(Eigen::Vector4d(value.tail<4>())).normalized();
}

std::vector<Vector3d> placesAlong(const Trajectory& trajectory, const Isometry3d& place) {
  std::vector<Vector3d> places;
  for (double t = trajectory.begin(); t < trajectory.end(); t += kBetweenPlaces)
    places.push_back(place * trajectory.pose(t).translation());
  places.push_back(place * trajectory.pose(trajectory.end()).translation());
  return places;
}

Isometry3d placeInHall(const Trajectory& trajectory) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : placesAlong(trajectory, Isometry3d::Identity())) box.extend(p);
  const Vector3d floor(box.center().x(), box.center().y(), box.min().z() - kFloorBelow);
  return Isometry3d(Eigen::Translation3d(-floor));
}

Isometry3d placeInStreet(const Trajectory& trajectory, const Vector3d& start) {
  const Vector3d origin = trajectory.pose(trajectory.begin()).translation();
  Eigen::Vector2d farthest(1e-9, 0);
  for (const Vector3d& p : placesAlong(trajectory, Isometry3d::Identity())) {
    const Eigen::Vector2d way = (p - origin).head<2>();
    if (way.norm() > farthest.norm()) farthest = way;
  }
  const double heading = std::atan2(farthest.y(), farthest.x());
  return Eigen::Translation3d(start) * Eigen::AngleAxisd(-heading, Vector3d::UnitZ()) * Eigen::Translation3d(-origin);
}

}  // namespace gms_ransac
