#include "datasets/bag_writer.h"

namespace gms_ransac {

namespace {

// Ground truth further than this from the first and last image is not written, seconds: a replay of a shortened
// sequence would show only tf for most of its time.
constexpr double kTruthMargin = 0.5;
const cv::Size kOpenNiSize(640, 480);
// Added to the relative times of KITTI's times.txt, which ROS would take for "not set": the day of the recording,
// seconds.
constexpr double kKittiStart = 1317042272;

CameraIntrinsics bagIntrinsics(const Dataset& dataset, bool openni_camera_info) {
  if (writesFactoryCalibration(dataset, openni_camera_info)) return openNiIntrinsics();
  if (dataset.intrinsics()) return *dataset.intrinsics();
  throw DatasetError(dataset.path() + ": has neither camera.txt nor calib.txt, so there is no camera_info to write");
}

}  // namespace

bool writesFactoryCalibration(const Dataset& dataset, bool openni_camera_info) {
  return dataset.kind() == DatasetKind::kTum && (openni_camera_info || !dataset.intrinsics()) &&
         dataset.image(0).size() == kOpenNiSize;
}

void exportToBag(const Dataset& dataset, const std::string& path, bool openni_camera_info,
                 const std::function<void()>& written) {
  const bool tum = dataset.kind() == DatasetKind::kTum;
  if (!tum && dataset.kind() != DatasetKind::kKitti) {
    throw DatasetError(dataset.path() + ": only TUM and KITTI folders can be turned into a bag");
  }
  const double start = tum ? 0 : kKittiStart;
  BagWriter bag(path, tum ? BagLayout::kTum : BagLayout::kKitti, bagIntrinsics(dataset, openni_camera_info));
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
