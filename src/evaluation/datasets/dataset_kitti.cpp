// KITTI odometry layout: image_0/ (or image_l/) in name order, optional calib.txt (P0: the left grey camera), poses.txt
// (3 x 4, row major, of the left grey camera) and times.txt (seconds); line i belongs to the i-th image. The folder of
// one camera (.../06/image_1) is a set, too: its calibration and its place are those of P1. image_1/ (or image_r/) are
// the images of the right camera, whose calibration is P1.
#include <algorithm>
#include <filesystem>

#include "datasets/dataset_text.h"

namespace gms_ransac {

namespace {

constexpr double kNominalPeriod = 0.1;  // KITTI's cameras run at 10 Hz; used without times.txt

/// Names of the images of a folder with `prefix` before each, sorted.
std::vector<std::string> listImages(const std::string& folder, const std::string& prefix) {
  std::vector<std::string> names;
  std::error_code problem;
  const std::filesystem::directory_iterator entries(folder, problem);
  if (problem) throw DatasetError(folder + ": " + problem.message());
  for (const auto& entry : entries) {
    const std::string suffix = entry.path().extension().string();
    if (suffix != ".png" && suffix != ".jpg" && suffix != ".jpeg" && suffix != ".pgm") continue;
    names.push_back(prefix + entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  if (names.empty()) throw DatasetError(folder + ": holds no .png, .jpg or .pgm image");
  return names;
}

/// One camera of the rig.
struct KittiCamera {
  CameraIntrinsics intrinsics;
  Eigen::Vector3d place;  ///< in the left grey camera, metres
};

/// `matrix`: "P0", "P1", ... Throws DatasetError if a file lacks one that is `required`.
std::optional<KittiCamera> readCalibration(const std::string& file, const std::string& matrix, bool required = true) {
  if (!isFile(file)) return std::nullopt;
  for (const TextLine& line : readLines(file)) {
    if (line.fields[0] != matrix + ":") continue;
    const std::vector<double> p =
        numbersAt(file, line, 1, 12, matrix + ": and twelve numbers of a 3 x 4 projection matrix");
    const CameraIntrinsics k = {p[0], p[5], p[2], p[6], "", {}};
    if (!k.calibrated()) failAt(file, line, "the focal lengths in " + matrix + " must be positive");
    return KittiCamera{k, {-(p[3] - k.cx * p[11]) / k.fx, -(p[7] - k.cy * p[11]) / k.fy, -p[11]}};
  }
  if (!required) return std::nullopt;
  throw DatasetError(file + ": has no line that starts with '" + matrix + ":'");
}

std::vector<Eigen::Isometry3d> readPoses(const std::string& file) {
  std::vector<Eigen::Isometry3d> poses;
  if (!isFile(file)) return poses;
  for (const TextLine& line : readLines(file)) {
    const std::vector<double> v = numbersAt(file, line, 0, 12, "twelve numbers of a 3 x 4 pose");
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.matrix().topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(v.data());
    // Orthonormal to the digits printed, which a swapped column or row order is not, and no mirror.
    const Eigen::Matrix3d R = pose.linear();
    if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 0.01 || R.determinant() < 0) {
      failAt(file, line, "the left 3 x 3 part is not a rotation");
    }
    poses.push_back(pose);
  }
  return poses;
}

std::vector<double> readTimes(const std::string& file) {
  std::vector<double> times;
  if (!isFile(file)) return times;
  for (const TextLine& line : readLines(file)) times.push_back(numbersAt(file, line, 0, 1, "one time stamp")[0]);
  return times;
}

}  // namespace

void Dataset::readKitti() {
  const auto rig = kittiRigOf(path_);
  const std::string root = rig.value_or(path_), camera = std::filesystem::path(path_).filename().string();
  const std::string left = isFolder(joinPath(root, "image_0")) ? "image_0" : "image_l";
  const char number = !rig || camera == "image_l" ? '0' : camera == "image_r" ? '1' : camera.back();
  const std::string matrix = {'P', number};
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  if (rig || !intrinsics_) {
    if (const auto found = readCalibration(joinPath(root, "calib.txt"), matrix)) {
      place = found->place;
      if (!intrinsics_) intrinsics_source_ = "calib.txt, " + matrix;
      if (!intrinsics_) intrinsics_ = found->intrinsics;
    }
  }
  const std::vector<std::string> names = rig ? listImages(path_, "") : listImages(joinPath(path_, left), left + "/");
  const std::string right = left == "image_0" ? "image_1" : "image_r";
  if (!rig && isFolder(joinPath(root, right))) {
    const auto found = readCalibration(joinPath(root, "calib.txt"), "P1", false);
    if (found && found->place.x() > 0) right_camera_ = RightCamera{found->intrinsics, found->place.x()};
  }
  const std::vector<Eigen::Isometry3d> poses = readPoses(joinPath(root, "poses.txt"));
  if (!poses.empty() && poses.size() != names.size()) {
    const bool fewer = poses.size() < names.size();
    notes_.push_back(joinPath(root, "poses.txt") + ": has " + std::to_string(poses.size()) + " poses for " +
                     std::to_string(names.size()) +
                     " images; line i belongs to the i-th image in name order, and the " +
                     (fewer ? "last images have no true pose" : "last lines are not used"));
  }
  const std::vector<double> times = readTimes(joinPath(root, "times.txt"));
  if (!times.empty() && times.size() < names.size()) {
    throw DatasetError(joinPath(root, "times.txt") + ":" + std::to_string(times.size()) + ": the file ends after " +
                       std::to_string(times.size()) + " lines, but there are " + std::to_string(names.size()) +
                       " images");
  }

  for (size_t i = 0; i < names.size(); ++i) {
    DatasetFrame frame = {names[i], times.empty() ? static_cast<double>(i) * kNominalPeriod : times[i]};
    // The images of one moment have one name.
    const std::string twin = right + names[i].substr(std::min(names[i].size(), left.size()));
    if (right_camera_ && isFile(joinPath(root, twin))) frame.right = twin;
    if (i < poses.size()) {
      frame.pose = poses[i] * Eigen::Translation3d(place);
      trajectory_.push_back({frame.stamp, *frame.pose});
    }
    frames_.push_back(frame);
  }
}

}  // namespace gms_ransac
