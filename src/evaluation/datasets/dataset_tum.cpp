// TUM RGB-D layout: rgb.txt (stamp, file), optional depth.txt (stamp, file), optional groundtruth.txt (stamp, position,
// quaternion x y z w); associated by time.
#include <algorithm>
#include <cmath>

#include "datasets/dataset_text.h"

namespace gms_ransac {

namespace {

// TUM's own association script pairs colour and depth that are at most this far apart, seconds.
constexpr double kDepthAssociation = 0.02;
// Files have four digits; what is further from unit length is no quaternion, and squares of it may be beyond a double.
constexpr double kQuaternionRounding = 0.5;

struct StampedFile {
  double stamp;
  std::string file;
};

std::vector<StampedFile> readImageList(const std::string& file) {
  std::vector<StampedFile> list;
  for (const TextLine& line : readLines(file)) {
    const std::string what = "a time stamp and a file name";
    if (line.fields.size() != 2) failAt(file, line, "expected " + what);
    list.push_back({numberAt(file, line, line.fields[0], what), line.fields[1]});
  }
  if (list.empty()) throw DatasetError(file + ": lists no image");
  return list;
}

std::vector<StampedPose> readTrajectory(const std::string& file) {
  std::vector<StampedPose> trajectory;
  for (const TextLine& line : readLines(file)) {
    const std::vector<double> v = numbersAt(file, line, 0, 8, "a pose (stamp tx ty tz qx qy qz qw)");
    const Eigen::Quaterniond quaternion(v[7], v[4], v[5], v[6]);
    if (std::abs(quaternion.norm() - 1) > kQuaternionRounding)
      failAt(file, line, "the quaternion is not of unit length");
    StampedPose pose{v[0], Eigen::Isometry3d(quaternion.normalized())};
    pose.pose.translation() = Eigen::Vector3d(v[1], v[2], v[3]);
    if (!trajectory.empty() && pose.stamp < trajectory.back().stamp)
      failAt(file, line, "the time stamps run backwards");
    trajectory.push_back(pose);
  }
  return trajectory;
}

/// Entry of the list nearest in time, or null.
const StampedFile* nearestFile(const std::vector<StampedFile>& sorted, double stamp) {
  const auto after = std::lower_bound(sorted.begin(), sorted.end(), stamp,
                                      [](const StampedFile& entry, double t) { return entry.stamp < t; });
  const StampedFile* nearest = nullptr;
  for (auto it : {after == sorted.begin() ? after : after - 1, after}) {
    if (it == sorted.end()) continue;
    if (!nearest || std::abs(it->stamp - stamp) < std::abs(nearest->stamp - stamp)) nearest = &*it;
  }
  return nearest && std::abs(nearest->stamp - stamp) <= kDepthAssociation ? nearest : nullptr;
}

}  // namespace

void Dataset::readTum() {
  std::vector<StampedFile> depth;
  if (isFile(joinPath(path_, "depth.txt"))) depth = readImageList(joinPath(path_, "depth.txt"));
  const auto gone = std::remove_if(depth.begin(), depth.end(),
                                   [&](const auto& entry) { return !isFile(joinPath(path_, entry.file)); });
  if (gone != depth.end()) {
    notes_.push_back(joinPath(path_, "depth.txt") + ": " + std::to_string(depth.end() - gone) + " of the " +
                     std::to_string(depth.size()) + " images are not there; their frames have no depth");
    depth.erase(gone, depth.end());
  }
  std::sort(depth.begin(), depth.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  if (isFile(joinPath(path_, "groundtruth.txt"))) trajectory_ = readTrajectory(joinPath(path_, "groundtruth.txt"));

  for (const StampedFile& entry : readImageList(joinPath(path_, "rgb.txt"))) {
    DatasetFrame frame = {entry.file, entry.stamp, truthAt(entry.stamp)};
    if (const StampedFile* nearest = nearestFile(depth, entry.stamp)) {
      frame.depth = nearest->file;
      frame.depth_stamp = nearest->stamp;
    }
    frames_.push_back(frame);
  }
}

}  // namespace gms_ransac
