// Paths from files of poses: what is read, the curve through it against a drawn motion, and the scenes seen along it.
#include "scenes/scene_trajectory.h"

#include <cmath>
#include <functional>
#include <iomanip>
#include <sstream>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "datasets/dataset_text.h"
#include "says.h"
#include "scenes/scene.h"
#include "scratch_folder.h"

namespace gms_ransac {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

const Isometry3d kCameraInImu =
    Eigen::Translation3d(-0.02, -0.06, 0.01) * Quaterniond(0.7, 0.1, -0.05, 0.7).normalized();

/// A hand that waves a camera: up to 1.5 m/s, 9 m/s^2 and 100 degrees a second.
Isometry3d waved(double t) {
  const Vector3d position(std::sin(1.3 * t), 0.4 * std::sin(4 * t + 1), 1.2 + 0.2 * std::cos(5 * t));
  return Eigen::Translation3d(position) * Eigen::AngleAxisd(0.8 * t, Vector3d::UnitZ()) *
         Eigen::AngleAxisd(0.4 * std::sin(2 * t), Vector3d::UnitX()) *
         Eigen::AngleAxisd(-2 + 0.2 * std::cos(3 * t), Vector3d::UnitY());
}

std::vector<StampedPose> sampled(double rate, double seconds) {
  std::vector<StampedPose> poses;
  for (int i = 0; i <= std::lround(rate * seconds); ++i) poses.push_back({i / rate, waved(i / rate)});
  return poses;
}

double degreesBetween(const Isometry3d& a, const Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() * 180 / M_PI;
}

class TrajectoryFile : public ::testing::Test {
 protected:
  /// Stamp and numbers of a line, separated as the format wants it.
  using Line = std::function<void(std::ostream&, double, const Isometry3d&)>;

  static void writeTumLine(std::ostream& out, double stamp, const Isometry3d& pose) {
    out << 1300000000 + stamp << ' ' << pose.translation().transpose() << ' '
        << Quaterniond(pose.linear()).coeffs().transpose() << '\n';
  }
  static void writeKittiLine(std::ostream& out, double, const Isometry3d& pose) {
    Isometry3d camera_axes = Isometry3d::Identity();
    camera_axes.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;  // x right, y down, z forward from x forward, y left, z up
    for (int row = 0; row < 3; ++row) out << (camera_axes * pose).matrix().row(row) << (row < 2 ? ' ' : '\n');
  }
  static void writeEurocLine(std::ostream& out, double stamp, const Isometry3d& pose) {
    const Vector3d t = pose.translation();
    const Quaterniond q(pose.linear());
    out << std::llround(1400000000e9 + stamp * 1e9);
    for (const double value : {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z(), 0.1, 0.2, 0.3}) out << ',' << value;
    out << '\n';
  }
  std::string write(const std::string& name, const Line& line, const std::vector<StampedPose>& poses) const {
    std::ostringstream text;
    text << std::setprecision(15) << "# drawn\n";
    for (const StampedPose& sample : poses) line(text, sample.stamp, sample.pose);
    folder_.write(name, text.str());
    return folder_.path(name);
  }
  std::string complaint(const std::string& text, TrajectoryOptions options = {}) const {
    folder_.write("bad.txt", text);
    options.file = folder_.path("bad.txt");
    try {
      readTrajectory(options);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  const ScratchFolder folder_;
};

TEST_F(TrajectoryFile, OfEachFormatHoldsItsPoses) {
  const std::vector<StampedPose> truth = sampled(10, 3);
  std::vector<StampedPose> of_imu = truth;
  for (StampedPose& sample : of_imu) sample.pose = sample.pose * kCameraInImu.inverse();
  TrajectoryOptions tum, kitti, euroc, imu_in_tum;
  tum.file = write("tum.txt", writeTumLine, truth);
  kitti.file = write("kitti.txt", writeKittiLine, truth);
  euroc.file = write("data.csv", writeEurocLine, of_imu);
  imu_in_tum.file = write("imu.txt", writeTumLine, of_imu);
  imu_in_tum.imu = true;
  imu_in_tum.camera_in_imu = euroc.camera_in_imu = kCameraInImu;
  for (const TrajectoryOptions& options : {tum, kitti, euroc, imu_in_tum}) {
    const std::vector<StampedPose> poses = readTrajectory(options);
    ASSERT_EQ(poses.size(), truth.size()) << options.file;
    for (size_t i = 0; i < poses.size(); ++i) {
      EXPECT_NEAR(poses[i].stamp, truth[i].stamp, 1e-6);
      const Isometry3d moved = Eigen::Translation3d(-truth[0].pose.translation()) * truth[i].pose;
      EXPECT_LT((poses[i].pose.matrix() - moved.matrix()).norm(), 1e-9) << options.file << " " << i;
    }
  }
}

TEST_F(TrajectoryFile, IsCutAndScaled) {
  TrajectoryOptions options;
  options.file = write("tum.txt", writeTumLine, sampled(10, 3));
  options.from = 0.95;
  options.duration = 1.5;
  options.scale = 0.5;
  const std::vector<StampedPose> poses = readTrajectory(options);
  ASSERT_EQ(poses.size(), 15u);  // from 1.0 to 2.4 s
  const Vector3d moved = 0.5 * (waved(2.4).translation() - waved(1).translation());
  EXPECT_LT((poses.back().pose.translation() - moved).norm(), 1e-9);
  EXPECT_LT(degreesBetween(poses.back().pose, waved(2.4)), 1e-6);
}

TEST_F(TrajectoryFile, ComplainsWithFileAndLine) {
  const std::string good = "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n";
  TrajectoryOptions late, no_rate;
  late.from = 5;
  no_rate.pose_rate = 0;
  EXPECT_TRUE(says(complaint(good), {}));
  EXPECT_TRUE(says(complaint("# nothing\n"), {"bad.txt: has no poses"}));
  EXPECT_TRUE(says(complaint("# head\n1 2 3\n"), {"bad.txt:2: expected a pose: stamp x y z"}));
  EXPECT_TRUE(says(complaint(good + "3 0 0 0 0 0 0 one\n"), {"bad.txt:3: ", "'one' is not a finite number"}));
  EXPECT_TRUE(says(complaint(good + "3 0 0 0 0 0 1\n"), {"bad.txt:3: ", "found 7 fields"}));
  EXPECT_TRUE(says(complaint(good + "2 1 0 0 0 0 0 1\n"), {}));
  EXPECT_TRUE(says(complaint(good + "1.5 0 0 0 0 0 0 1\n"), {"bad.txt:3: the time stamps decrease"}));
  EXPECT_TRUE(says(complaint(good + "3 0 0 0 1 0 0 1\n"), {"bad.txt:3: the quaternion is not of unit length"}));
  EXPECT_TRUE(says(complaint(good + "3 0 0 0 0 0 1 0\n"), {"bad.txt:3: more than 90 degrees"}));
  TrajectoryOptions before_it;
  before_it.duration = 1;
  EXPECT_TRUE(says(complaint(good + "3 0 0 0 0 0 1 0\n", before_it), {}));
  EXPECT_TRUE(says(complaint("1 0 0 0 0 2 0 0 0 0 1 0\n"), {"bad.txt:1: the first three columns are no rotation"}));
  EXPECT_TRUE(says(complaint("1,0,0,0,1,0,0,0\n"), {"bad.txt: has poses of an IMU; give --camera-in-imu"}));
  EXPECT_TRUE(says(complaint(good, late), {"bad.txt: fewer than two poses from 5 s on; the file has 1 s"}));
  EXPECT_TRUE(says(complaint(good, no_rate), {"pose_rate is 0; it must be between 0.1 and 1000"}));
  TrajectoryOptions missing;
  missing.file = folder_.path("missing");
  EXPECT_THROW(readTrajectory(missing), DatasetError);
}

TEST(Trajectory, LiesCloseToItsPosesAndToTheMotionBetween) {
  for (const auto& [rate, at_pose, between] : {std::make_tuple(10.0, 2e-4, 2e-3), std::make_tuple(200.0, 1e-4, 1e-4)}) {
    const Trajectory curve(sampled(rate, 8));
    EXPECT_DOUBLE_EQ(curve.begin(), 0);
    EXPECT_DOUBLE_EQ(curve.end(), 8);
    for (int i = 0; i < 8 * rate; ++i) {
      const double t = i / rate, middle = (i + 0.5) / rate;
      EXPECT_LT((curve.pose(t).translation() - waved(t).translation()).norm(), at_pose) << rate << " Hz, " << t;
      EXPECT_LT(degreesBetween(curve.pose(t), waved(t)), at_pose * 180 / M_PI) << rate << " Hz, " << t;
      EXPECT_LT((curve.pose(middle).translation() - waved(middle).translation()).norm(), between) << middle;
      EXPECT_LT(degreesBetween(curve.pose(middle), waved(middle)), between * 180 / M_PI) << middle;
    }
  }
}

TEST(Trajectory, AccelerationsAreContinuousAndThoseOfTheMotion) {
  const Trajectory curve(sampled(100, 8));
  const double h = 1e-3;
  const auto acceleration = [h](auto&& pose, double t) -> Vector3d {
    return (pose(t - h).translation() - 2 * pose(t).translation() + pose(t + h).translation()) / (h * h);
  };
  const auto rate = [h](auto&& pose, double t) -> Vector3d {
    const Eigen::AngleAxisd rotation(pose(t - h).linear().transpose() * pose(t + h).linear());
    return rotation.angle() / (2 * h) * rotation.axis();
  };
  const auto of_curve = [&curve](double t) { return curve.pose(t); };
  Vector3d last_acceleration = acceleration(of_curve, 0.498), last_rate = rate(of_curve, 0.498);
  for (int i = 0; i < 3500; ++i) {  // in steps of 2 ms, over every knot
    const double t = 0.5 + 0.002 * i;
    EXPECT_LT((acceleration(of_curve, t) - acceleration(waved, t)).norm(), 0.05) << t;
    EXPECT_LT((rate(of_curve, t) - rate(waved, t)).norm(), 1e-3) << t;
    EXPECT_LT((acceleration(of_curve, t) - last_acceleration).norm(), 0.12) << t << ": the jerk is 50 m/s^3 at most";
    EXPECT_LT((rate(of_curve, t) - last_rate).norm(), 0.012) << t;
    last_acceleration = acceleration(of_curve, t);
    last_rate = rate(of_curve, t);
  }
}

/// A motion capture with errors of half a millimetre.
std::vector<StampedPose> captured() {
  std::vector<StampedPose> poses = sampled(100, 8);
  cv::RNG rng(1);
  for (StampedPose& sample : poses) {
    for (int k = 0; k < 3; ++k) sample.pose.translation()[k] += rng.uniform(-0.0005, 0.0005);
  }
  return poses;
}

/// The largest difference of accelerations, over 1 ms, from those of the motion.
double accelerationError(const Trajectory& curve, double from, double to) {
  const double h = 1e-3;
  double largest = 0;
  for (double t = from; t < to; t += 0.01) {
    const auto error = [&](double at) -> Vector3d { return curve.pose(at).translation() - waved(at).translation(); };
    largest = std::max(largest, (error(t - h) - 2 * error(t) + error(t + h)).norm() / (h * h));
  }
  return largest;
}

TEST(Trajectory, NoiseOfMotionCaptureIsNoAcceleration) {
  // Second differences of the poses themselves have an error of 12 m/s^2.
  EXPECT_LT(accelerationError(Trajectory(captured()), 0.5, 7.5), 1);
}

TEST(Trajectory, CrossesAHoleOfMotionCapture) {
  std::vector<StampedPose> poses = captured();
  poses.erase(poses.begin() + 400, poses.begin() + 440);
  const Trajectory curve(poses);
  for (double t = 0; t < 8; t += 0.01)
    EXPECT_LT((curve.pose(t).translation() - waved(t).translation()).norm(), 0.05) << t;
  EXPECT_LT(accelerationError(curve, 0.5, 7.5), 10);
}

SceneOptions along(const std::vector<StampedPose>& poses, const std::string& scene = "room") {
  SceneOptions options;
  options.scene = scene;
  options.size = {320, 240};
  options.noise = options.blur = 0;
  if (!poses.empty()) options.trajectory = std::make_shared<Trajectory>(poses);
  return options;
}

TEST(SceneAlongATrajectory, ShowsWhatTheSameCameraSeesOnTheScenesOwnPath) {
  SceneOptions own = along({}, "street");
  own.sway = 0;
  own.turn = 5;
  own.focal_length = 1500;  // few houses to paint
  own.readout = 0.5;
  const Scene street(own);
  std::vector<StampedPose> poses;
  const Eigen::AngleAxisd heading(0.7, Vector3d::UnitZ());  // of the file's world
  for (int i = 0; i < 12; ++i) poses.push_back({i / own.rate, heading * street.pose(i)});
  SceneOptions options = along(poses, "street");
  options.focal_length = own.focal_length;
  options.readout = own.readout;
  const Scene scene(options);
  ASSERT_EQ(scene.frameCount(), 10);
  for (const int i : {8, 9}) {
    EXPECT_LT((scene.pose(i).matrix() - street.pose(i + 1).matrix()).norm(), 1e-5);
    const RenderedFrame frame = scene.render(i), expected = street.render(i + 1);
    EXPECT_LT(cv::norm(frame.image, expected.image, cv::NORM_L1) / frame.image.total(), 0.02);
    EXPECT_GT(cv::norm(frame.image, street.render(i).image, cv::NORM_L1) / frame.image.total(), 5);
    EXPECT_EQ(frame.stamp, kSceneStart + i / own.rate);
  }
}

TEST(SceneAlongATrajectory, TheHallHoldsThePathAndThePosesAreThoseOfTheFile) {
  std::vector<StampedPose> poses = sampled(20, 10);
  for (StampedPose& sample : poses) sample.pose.translation() *= 8;  // 16 m x 6 m
  const Scene scene(along(poses));
  const int frames = scene.frameCount();
  ASSERT_EQ(frames, 299);
  EXPECT_NO_THROW(scene.requireFreePath(frames));
  for (int i = 2; i < frames; i += 3) {  // a frame later than the poses, which are at 20 Hz
    const Isometry3d expected = scene.pose(2) * poses[2].pose.inverse() * poses[2 * (i - 2) / 3 + 2].pose;
    EXPECT_LT((scene.pose(i).matrix() - expected.matrix()).norm(), 1e-4) << i;
    EXPECT_GT(scene.pose(i).translation().z(), 0.9);
    for (const cv::Point2d& pixel : {cv::Point2d(10, 10), cv::Point2d(160, 120), cv::Point2d(310, 230)})
      EXPECT_GT(scene.depth(i, pixel), 0.3) << i;
  }
}

TEST(SceneAlongATrajectory, SaysWhereItDoesNotFit) {
  const auto complaint = [](const SceneOptions& options) -> std::string {
    try {
      const Scene scene(options);
      scene.requireFreePath(std::min(scene.frameCount(), 1000));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const auto straight = [](const Vector3d& velocity, double seconds) {
    std::vector<StampedPose> poses;
    for (int i = 0; i <= 10 * seconds; ++i) {
      const Vector3d position = i / 10.0 * velocity;
      poses.push_back({i / 10.0, Eigen::Translation3d(position) * Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY())});
    }
    return poses;
  };
  EXPECT_TRUE(says(complaint(along(straight({30, 0, 0}, 4), "street")), {}));
  EXPECT_TRUE(says(complaint(along(straight({30, 0, 0}, 6), "street")),
                   {"the camera leaves the free space of the street at frame", "s after the first"}));
  EXPECT_TRUE(says(complaint(along(straight({1, 0, -1}, 6), "street")), {"leaves the free space of the street"}));
  EXPECT_TRUE(says(complaint(along(straight({30, 0, 0}, 3))), {}));
  EXPECT_TRUE(says(complaint(along(straight({30, 0, 0}, 4))), {"the trajectory is 120 m x 0 m in size", "100 m"}));
  SceneOptions wide = along(straight({0.5, 0, 0}, 4));
  wide.offset = 0.6;
  EXPECT_TRUE(says(complaint(wide), {}));
  wide.trajectory = nullptr;
  EXPECT_TRUE(says(complaint(wide), {}));
  wide.offset = 2;
  EXPECT_TRUE(says(complaint(wide), {"the camera leaves the free space of the room at frame", "change the offset"}));
}

TEST(StereoOffset, IsTheBaselineOfTwoCameras) {
  SceneOptions options = along(sampled(20, 2));
  options.offset = 0.54;  // KITTI's
  const Scene right(options);
  options.offset = 0;
  const Scene left(options);
  const double f = left.intrinsics().fx;
  const RenderedFrame left_frame = left.render(5), right_frame = right.render(5);
  const Isometry3d right_in_left = left_frame.camera_pose.inverse() * right_frame.camera_pose;
  EXPECT_LT((right_in_left.matrix() - Isometry3d(Eigen::Translation3d(0.54, 0, 0)).matrix()).norm(), 1e-9);
  double same = 0, shifted = 0;
  int count = 0;
  for (int y = 20; y < 220; y += 4) {
    for (int x = 20; x < 300; x += 4) {
      const double depth = left.depth(5, cv::Point2d(x, y)), place = x - f * 0.54 / depth;
      if (place < 10 || std::abs(right.depth(5, {place, 1.0 * y}) - depth) > 1e-3 * depth) continue;  // hidden
      const auto grey = [](const cv::Mat& image, double u, int v) {
        const int u0 = static_cast<int>(u);
        return image.at<uint8_t>(v, u0) * (1 - u + u0) + image.at<uint8_t>(v, u0 + 1) * (u - u0);
      };
      same += std::abs(left_frame.image.at<uint8_t>(y, x) - grey(right_frame.image, place, y));
      shifted += std::abs(left_frame.image.at<uint8_t>(y, x) - grey(right_frame.image, place - 6, y));
      ++count;
    }
  }
  EXPECT_GT(count, 1000);
  EXPECT_LT(same, 0.5 * shifted);
}

}  // namespace
}  // namespace gms_ransac
