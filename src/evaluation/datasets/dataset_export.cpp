#include "datasets/dataset_export.h"

#include "datasets/bag_writer.h"

namespace gms_ransac {

namespace {

// Ground truth further than this from the first and last image is not written, seconds: a replay of a shortened
// sequence would show only tf for most of its time.
constexpr double kTruthMargin = 0.5;
const cv::Size kOpenNiSize(640, 480);

CameraIntrinsics bagIntrinsics(const Dataset& dataset, const BagExportOptions& options) {
  if (writesFactoryCalibration(dataset, options)) return openNiIntrinsics();
  if (dataset.intrinsics()) return *dataset.intrinsics();
  throw DatasetError(dataset.path() + ": has neither camera.txt nor calib.txt, so there is no camera_info to write");
}

void exportTum(const Dataset& dataset, const std::string& path, const BagExportOptions& options,
               const std::function<void()>& written) {
  BagWriter bag(path, BagLayout::kTum, bagIntrinsics(dataset, options));
  const std::vector<DatasetFrame>& frames = dataset.frames();
  for (const StampedPose& sample : dataset.trajectory()) {
    if (sample.stamp < frames.front().stamp - kTruthMargin) continue;
    if (sample.stamp > frames.back().stamp + kTruthMargin) break;
    bag.writeGroundTruth(sample.stamp, sample.pose);
  }
  std::string last_depth;
  for (size_t i = 0; i < frames.size(); ++i) {
    const int index = static_cast<int>(i);
    bag.writeImage(frames[i].stamp, dataset.image(index, true));
    // Two images may be nearest to the same depth image.
    if (!frames[i].depth.empty() && frames[i].depth != last_depth) {
      bag.writeDepth(frames[i].depth_stamp, dataset.depth(index));
      last_depth = frames[i].depth;
    }
    written();
  }
  bag.close();
}

void exportKitti(const Dataset& dataset, const std::string& path, const BagExportOptions& options,
                 const std::function<void()>& written) {
  BagWriter bag(path, BagLayout::kKitti, bagIntrinsics(dataset, options));
  for (const StampedPose& sample : dataset.trajectory()) {
    bag.writeGroundTruth(options.kitti_start + sample.stamp, sample.pose);
  }
  for (size_t i = 0; i < dataset.frames().size(); ++i) {
    bag.writeImage(options.kitti_start + dataset.frames()[i].stamp, dataset.image(static_cast<int>(i), false));
    written();
  }
  bag.close();
}

}  // namespace

bool writesFactoryCalibration(const Dataset& dataset, const BagExportOptions& options) {
  return dataset.kind() == DatasetKind::kTum && (options.openni_camera_info || !dataset.intrinsics()) &&
         dataset.image(0).size() == kOpenNiSize;
}

void exportToBag(const Dataset& dataset, const std::string& path, const BagExportOptions& options,
                 const std::function<void()>& written) {
  switch (dataset.kind()) {
    case DatasetKind::kTum:
      return exportTum(dataset, path, options, written);
    case DatasetKind::kKitti:
      return exportKitti(dataset, path, options, written);
    case DatasetKind::kImagePairs:
    case DatasetKind::kBag:
      throw DatasetError(dataset.path() + ": only TUM and KITTI folders can be turned into a bag");
  }
}

}  // namespace gms_ransac
