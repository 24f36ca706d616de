// KITTI odometry layout: image_0/ (or image_l/) in name order, optional calib.txt (P0: the left grey camera), poses.txt
// (3 x 4, row major) and times.txt (seconds); line i belongs to the i-th image.
#include <algorithm>
#include <filesystem>

#include "datasets/dataset_text.h"

namespace gms_ransac {

namespace {

constexpr double kNominalPeriod = 0.1;  // KITTI's cameras run at 10 Hz; used without times.txt

/// Paths relative to the set's folder, sorted by name.
std::vector<std::string> listImages(const std::string& folder, const std::string& subfolder) {
  std::vector<std::string> names;
  std::error_code problem;
  const std::filesystem::directory_iterator entries(joinPath(folder, subfolder), problem);
  if (problem) throw DatasetError(joinPath(folder, subfolder) + ": " + problem.message());
  for (const auto& entry : entries) {
    const std::string suffix = entry.path().extension().string();
    if (suffix != ".png" && suffix != ".jpg" && suffix != ".jpeg" && suffix != ".pgm") continue;
    names.push_back(subfolder + "/" + entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  if (names.empty()) throw DatasetError(joinPath(folder, subfolder) + ": holds no .png, .jpg or .pgm image");
  return names;
}

std::optional<CameraIntrinsics> readCalibration(const std::string& file) {
  if (!isFile(file)) return std::nullopt;
  for (const TextLine& line : readLines(file)) {
    if (line.fields[0] != "P0:") continue;
    const std::vector<double> p = numbersAt(file, line, 1, 12, "P0: and twelve numbers of a 3 x 4 projection matrix");
    const CameraIntrinsics intrinsics = {p[0], p[5], p[2], p[6], "", {}};
    if (!intrinsics.calibrated()) failAt(file, line, "the focal lengths in P0 must be positive");
    return intrinsics;
  }
  throw DatasetError(file + ": has no line that starts with 'P0:'");
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
  if (!intrinsics_) {
    intrinsics_ = readCalibration(joinPath(path_, "calib.txt"));
    intrinsics_source_ = "calib.txt";
  }
  const std::vector<std::string> names =
      listImages(path_, isFolder(joinPath(path_, "image_0")) ? "image_0" : "image_l");
  const std::vector<Eigen::Isometry3d> poses = readPoses(joinPath(path_, "poses.txt"));
  const std::vector<double> times = readTimes(joinPath(path_, "times.txt"));
  if (!times.empty() && times.size() < names.size()) {
    throw DatasetError(joinPath(path_, "times.txt") + ":" + std::to_string(times.size()) + ": the file ends after " +
                       std::to_string(times.size()) + " lines, but there are " + std::to_string(names.size()) +
                       " images");
  }

  for (size_t i = 0; i < names.size(); ++i) {
    DatasetFrame frame = {names[i], times.empty() ? static_cast<double>(i) * kNominalPeriod : times[i]};
    if (i < poses.size()) {
      frame.pose = poses[i];
      trajectory_.push_back({frame.stamp, poses[i]});
    }
    frames_.push_back(frame);
  }
}

}  // namespace gms_ransac
