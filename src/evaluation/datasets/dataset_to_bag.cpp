// Program: writes a TUM or KITTI folder as a bag with the topic names of the official TUM bags or of kitti2bag.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <boost/program_options.hpp>

#include "datasets/bag_writer.h"
#include "datasets/dataset.h"
#include "program.h"

namespace {

namespace po = boost::program_options;
using namespace gms_ransac;

// Ground truth further than this from the first and last image is not written, seconds: a replay of a shortened
// sequence would show only tf for most of its time.
constexpr double kTruthMargin = 0.5;
const cv::Size kOpenNiSize(640, 480);
// Added to the relative times of KITTI's times.txt, which ROS would take for "not set": the day of the recording,
// seconds.
constexpr double kKittiStart = 1317042272;

/// Colour images, depth at its own stamps and the ground truth at its own rate (TUM); grey images of one or two cameras
/// and ground truth (KITTI).
void writeDataset(const Dataset& dataset, const std::string& path, const CameraIntrinsics& intrinsics) {
  const bool tum = dataset.kind() == DatasetKind::kTum;
  const double start = tum ? 0 : kKittiStart;
  BagWriter bag(path, tum ? BagLayout::kTum : BagLayout::kKitti, intrinsics);
  const std::vector<DatasetFrame>& frames = dataset.frames();
  for (const StampedPose& sample : dataset.trajectory()) {
    if (sample.stamp < frames.front().stamp - kTruthMargin) continue;
    if (sample.stamp > frames.back().stamp + kTruthMargin) break;
    bag.writeGroundTruth(start + sample.stamp, sample.pose);
  }
  Progress progress("writing frame", static_cast<int>(frames.size()));
  std::string last_depth;
  for (size_t i = 0; i < frames.size(); ++i) {
    const int index = static_cast<int>(i);
    bag.writeImage(start + frames[i].stamp, dataset.image(index, tum));
    if (!frames[i].right.empty())
      bag.writeRightImage(start + frames[i].stamp, dataset.right(index), *dataset.rightCamera());
    // Two images may be nearest to the same depth image.
    if (!frames[i].depth.empty() && frames[i].depth != last_depth) {
      bag.writeDepth(frames[i].depth_stamp, dataset.depth(index));
      last_depth = frames[i].depth;
    }
    progress.advanceUnlessInterrupted();
  }
  bag.close();
}

/// The calibration in the bag, and the command that replays it.
std::string summaryOf(const Dataset& dataset, const CameraIntrinsics& k, const std::string& bag) {
  std::ostringstream text;
  const bool tum = dataset.kind() == DatasetKind::kTum, stereo = dataset.rightCamera().has_value();
  text << bag << ": camera_info has fx " << k.fx << ", fy " << k.fy << ", cx " << k.cx << ", cy " << k.cy
       << (std::any_of(k.distortion.begin(), k.distortion.end(), [](double d) { return d != 0; })
               ? " and the distortion"
               : ", no distortion");
  if (stereo) text << "; the right camera is " << dataset.rightCamera()->baseline << " m to the right";
  text << "\nreplay it: roslaunch gms_ransac "
       << (tum ? "tum.launch bag:=" : "kitti.launch variant:=odom camera:=gray_left bag:=") << bag;
  const std::vector<DatasetFrame>& frames = dataset.frames();
  const bool depth = std::any_of(frames.begin(), frames.end(), [](const auto& frame) { return !frame.depth.empty(); });
  if (depth) text << " scale:=depth";
  if (stereo) text << " stereo:=true";
  return text.str();
}

int datasetToBag(const Arguments& arguments) {
  DatasetOptions dataset_options;
  std::string folder, bag, camera_info = "folder";
  po::options_description options;
  auto add = options.add_options();
  add("camera-info", withDefault(camera_info),
      "TUM: folder (camera.txt, or openni without that file) or openni (the driver's factory values 525, 319.5, 239.5, "
      "no distortion, as in the official bags)");
  add("intrinsics", po::value(&dataset_options.intrinsics),
      "fx,fy,cx,cy[,k1,k2,p1,p2[,k3]] for camera_info instead of the folder's");
  const char* usage =
      "dataset_to_bag DIR OUT.bag [options]\n\nWrites a TUM RGB-D folder (rgb.txt, optional depth.txt and "
      "groundtruth.txt) or a KITTI odometry\nfolder (image_0/, calib.txt, optional image_1/, poses.txt and times.txt) "
      "as a bag with the topics,\nframes, camera_info and ground-truth tf of the official TUM bags or of kitti2bag's "
      "odometry bags.\nA KITTI folder with image_1/ becomes a bag of both cameras.";
  const std::vector<Positional> positional = {{"folder", 1, po::value(&folder)}, {"bag", 1, po::value(&bag)}};
  if (!parseCommandLine(arguments, usage, options, positional)) return 0;
  if (folder.empty() || bag.empty()) {
    throw std::invalid_argument("a folder and a bag to write are needed; see dataset_to_bag --help");
  }
  if (std::filesystem::exists(bag)) {
    throw std::invalid_argument(bag + ": exists; remove it, or write to another file");
  }
  if (camera_info != "openni" && camera_info != "folder") {
    throw std::invalid_argument("--camera-info is '" + camera_info + "'; it must be openni or folder");
  }
  const bool openni = camera_info == "openni" && dataset_options.intrinsics.empty();

  const Dataset dataset = Dataset::open(folder, dataset_options);
  for (const std::string& note : dataset.notes()) std::cerr << note << '\n';
  const bool tum = dataset.kind() == DatasetKind::kTum;
  if (!tum && dataset.kind() != DatasetKind::kKitti) {
    throw DatasetError(dataset.path() + ": only TUM and KITTI folders can be turned into a bag");
  }
  std::optional<CameraIntrinsics> intrinsics = dataset.intrinsics();
  if (tum && (openni || !intrinsics) && dataset.image(0).size() == kOpenNiSize) {
    std::cerr << folder << ": camera_info holds the OpenNI driver's factory values (525, 319.5, 239.5, no distortion)"
              << (intrinsics ? "" : ", since there is no camera.txt; give the camera's own with --intrinsics") << '\n';
    intrinsics = openNiIntrinsics();
  }
  if (!intrinsics) {
    throw DatasetError(dataset.path() + ": has neither camera.txt nor calib.txt, so there is no camera_info to write");
  }
  watchInterrupts();
  writeDataset(dataset, bag, *intrinsics);
  std::cout << summaryOf(dataset, *intrinsics, bag) << '\n';
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return gms_ransac::runProgram(argc, argv, datasetToBag); }
