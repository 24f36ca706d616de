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

}  // namespace

bool writesFactoryCalibration(const Dataset& dataset, const BagExportOptions& options) {
  return dataset.kind() == DatasetKind::kTum && (options.openni_camera_info || !dataset.intrinsics()) &&
         dataset.image(0).size() == kOpenNiSize;
}

void exportToBag(const Dataset& dataset, const std::string& path, const BagExportOptions& options,
                 const std::function<void()>& written) {
  const bool tum = dataset.kind() == DatasetKind::kTum;
  if (!tum && dataset.kind() != DatasetKind::kKitti) {
    throw DatasetError(dataset.path() + ": only TUM and KITTI folders can be turned into a bag");
  }
  const double start = tum ? 0 : options.kitti_start;
  BagWriter bag(path, tum ? BagLayout::kTum : BagLayout::kKitti, bagIntrinsics(dataset, options));
  const std::vector<DatasetFrame>& frames = dataset.frames();
  for (const StampedPose& sample : dataset.trajectory()) {
    if (sample.stamp < frames.front().stamp - kTruthMargin) continue;
    if (sample.stamp > frames.back().stamp + kTruthMargin) break;
    bag.writeGroundTruth(start + sample.stamp, sample.pose);
  }
  std::string last_depth;
  for (size_t i = 0; i < frames.size(); ++i) {
    const int index = static_cast<int>(i);
    bag.writeImage(start + frames[i].stamp, dataset.image(index, tum));
    // Two images may be nearest to the same depth image.
    if (!frames[i].depth.empty() && frames[i].depth != last_depth) {
      bag.writeDepth(frames[i].depth_stamp, dataset.depth(index));
      last_depth = frames[i].depth;
    }
    written();
  }
  bag.close();
}

}  // namespace gms_ransac
