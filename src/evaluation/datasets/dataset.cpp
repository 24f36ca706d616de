#include "datasets/dataset.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "datasets/dataset_text.h"
#include "features/encoded_image.h"

namespace gms_ransac {

namespace {

// A longer hole in the ground truth (TUM's motion capture runs at 100 Hz) is not interpolated across, seconds.
constexpr double kLongestPoseGap = 0.1;
constexpr double kDepthScale = 5000;  // grey values per metre of TUM's depth images

std::string withoutTrailingSlashes(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

bool hasKittiCamera(const std::string& folder) {
  return isFolder(joinPath(folder, "image_0")) || isFolder(joinPath(folder, "image_l"));
}

DatasetKind kindOf(const std::string& path) {
  if (isFile(path)) {
    if (std::filesystem::path(path).extension() == ".bag") return DatasetKind::kBag;
    throw DatasetError(path + ": is neither a folder nor a .bag file");
  }
  if (!isFolder(path)) throw DatasetError(path + ": no such folder or bag");
  if (const auto layout = layoutOf(path)) return *layout;
  throw DatasetError(path + ": holds neither rgb.txt (TUM), image_0/ (KITTI) nor pairs.txt (image pairs)");
}

/// One channel as float, multiplied by `factor`.
cv::Mat readScaled(const std::string& path, double factor) {
  if (!isFile(path)) throw DatasetError(path + ": no such image");
  const cv::Mat raw = readImageFile(path, cv::IMREAD_ANYDEPTH | cv::IMREAD_GRAYSCALE);
  if (raw.empty()) throw DatasetError(path + ": cannot be read as an image");
  cv::Mat scaled;
  raw.convertTo(scaled, CV_32F, factor);
  return scaled;
}

bool isOpenNiDefault(const CameraIntrinsics& k) {
  const CameraIntrinsics factory = openNiIntrinsics();
  return k.fx == factory.fx && k.fy == factory.fy && k.cx == factory.cx && k.cy == factory.cy;
}

}  // namespace

std::optional<DatasetKind> layoutOf(const std::string& folder) {
  if (isFile(joinPath(folder, "pairs.txt"))) return DatasetKind::kImagePairs;
  if (isFile(joinPath(folder, "rgb.txt"))) return DatasetKind::kTum;
  if (hasKittiCamera(folder) || kittiRigOf(folder)) return DatasetKind::kKitti;
  return std::nullopt;
}

std::optional<std::string> kittiRigOf(const std::string& folder) {
  const std::filesystem::path path = withoutTrailingSlashes(folder);
  const std::string camera = path.filename().string();
  if (camera.size() != 7 || camera.rfind("image_", 0) != 0 || !isFolder(folder)) return std::nullopt;
  const std::string rig = joinPath(folder, "..");
  return hasKittiCamera(rig) ? std::optional<std::string>(rig) : std::nullopt;
}

std::string setName(const std::string& path) {
  const std::filesystem::path plain = std::filesystem::absolute(withoutTrailingSlashes(path));
  const std::string last = plain.filename().string();
  return kittiRigOf(plain.string()) ? plain.parent_path().filename().string() + "/" + last : last.empty() ? path : last;
}

CameraIntrinsics openNiIntrinsics() { return {525, 525, 319.5, 239.5, "plumb_bob", {0, 0, 0, 0, 0}}; }

Dataset Dataset::open(const std::string& path, const DatasetOptions& options) {
  Dataset dataset;
  dataset.path_ = withoutTrailingSlashes(path);
  dataset.kind_ = kindOf(dataset.path_);
  if (dataset.kind_ == DatasetKind::kBag) {
    dataset.readBag(options);
  } else {
    dataset.intrinsics_ = readCameraFile(dataset.path_);
    dataset.intrinsics_source_ = "camera.txt";
    if (dataset.kind_ == DatasetKind::kTum) dataset.readTum();
    if (dataset.kind_ == DatasetKind::kKitti) dataset.readKitti();
    if (dataset.kind_ == DatasetKind::kImagePairs) dataset.readImagePairs();
    dataset.read_ = imagesOf(dataset.frames_, dataset.path_);
  }
  if (!options.intrinsics.empty()) {
    dataset.intrinsics_ = parseIntrinsics(options.intrinsics, "--intrinsics");
    dataset.intrinsics_source_ = "--intrinsics";
    dataset.advice_.clear();
  }
  return dataset;
}

std::string Dataset::calibrationText() const {
  if (!intrinsics_) return "no intrinsics, so no poses (see --intrinsics)";
  const CameraIntrinsics& k = *intrinsics_;
  std::ostringstream text;
  text << "calibration of " << intrinsics_source_ << ": fx " << k.fx << ", fy " << k.fy << ", cx " << k.cx << ", cy "
       << k.cy;
  const bool fisheye = k.distortion_model == "equidistant" && !k.distortion.empty();
  const bool distorted =
      fisheye || std::any_of(k.distortion.begin(), k.distortion.end(), [](double d) { return d != 0; });
  text << (distorted ? ", " + k.distortion_model : ", no distortion");
  if (distorted) {
    for (const double d : k.distortion) text << ' ' << d;
  }
  if (kind_ == DatasetKind::kBag && !distorted && isOpenNiDefault(k)) {
    text << " (what the OpenNI driver reports of every camera; give a real camera's own with --intrinsics)";
  }
  text << advice_;
  return text.str();
}

std::vector<DatasetPair> Dataset::pairs(int gap, int stride) const {
  std::vector<DatasetPair> chosen;
  const size_t step = static_cast<size_t>(std::max(1, stride));
  for (size_t i = 0; i < listed_pairs_.size(); i += step) chosen.push_back(listed_pairs_[i]);
  if (kind_ == DatasetKind::kImagePairs) return chosen;
  const size_t distance = static_cast<size_t>(std::max(1, gap));
  for (size_t i = 0; i + distance < frames_.size(); i += step) {
    chosen.push_back({static_cast<int>(i), static_cast<int>(i + distance)});
  }
  return chosen;
}

std::vector<DatasetPair> Dataset::spreadPairs(int gap, int count) const {
  const std::vector<DatasetPair> all = pairs(gap, 1);
  std::vector<DatasetPair> chosen;
  const size_t wanted = std::min(all.size(), static_cast<size_t>(count));
  for (size_t i = 0; i < wanted; ++i) chosen.push_back(all[i * all.size() / wanted]);
  return chosen;
}

std::optional<double> Dataset::stamp(int frame) const {
  if (kind_ == DatasetKind::kImagePairs) return std::nullopt;
  return frames_.at(static_cast<size_t>(frame)).stamp;
}

std::optional<Eigen::Isometry3d> Dataset::truthAt(double stamp) const {
  const auto after = std::lower_bound(trajectory_.begin(), trajectory_.end(), stamp,
                                      [](const StampedPose& pose, double t) { return pose.stamp < t; });
  if (after == trajectory_.end()) return std::nullopt;
  if (after->stamp == stamp) return after->pose;
  if (after == trajectory_.begin()) return std::nullopt;
  const StampedPose &a = *(after - 1), &b = *after;
  if (b.stamp - a.stamp > kLongestPoseGap) return std::nullopt;
  const double weight = (stamp - a.stamp) / (b.stamp - a.stamp);
  const Eigen::Quaterniond from(a.pose.linear()), to(b.pose.linear());
  Eigen::Isometry3d pose(from.slerp(weight, to));
  pose.translation() = (1 - weight) * a.pose.translation() + weight * b.pose.translation();
  return pose;
}

cv::Mat Dataset::depth(int frame) const {
  const std::string& file = frames_.at(static_cast<size_t>(frame)).depth;
  return file.empty() ? cv::Mat() : readScaled(joinPath(path_, file), 1.0 / kDepthScale);
}

cv::Mat Dataset::right(int frame) const {
  const std::string& file = frames_.at(static_cast<size_t>(frame)).right;
  return file.empty() ? cv::Mat() : readPicture(joinPath(path_, file), false);
}

cv::Mat Dataset::disparity(const DatasetPair& pair) const {
  return pair.disparity ? readScaled(joinPath(path_, pair.disparity->path), 1.0 / pair.disparity->scale) : cv::Mat();
}

}  // namespace gms_ransac
