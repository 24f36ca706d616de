// Program: writes a TUM or KITTI folder as a bag with the topic names of the official TUM bags or of kitti2bag.
#include <iostream>
#include <stdexcept>
#include <string>

#include <boost/program_options.hpp>

#include "datasets/bag_writer.h"
#include "program.h"

namespace {

namespace po = boost::program_options;
using namespace gms_ransac;

int datasetToBag(const Arguments& arguments) {
  DatasetOptions dataset_options;
  std::string folder, bag, camera_info;
  po::options_description options;
  auto add = options.add_options();
  add("camera-info", po::value(&camera_info)->default_value("folder"),
      "TUM: folder (camera.txt, or openni without that file) or openni (the driver's factory values 525, 319.5, 239.5, "
      "no distortion, as in the official bags)");
  add("intrinsics", po::value(&dataset_options.intrinsics),
      "fx,fy,cx,cy[,k1,k2,p1,p2[,k3]] for camera_info instead of the folder's");
  const char* usage =
      "dataset_to_bag DIR OUT.bag [options]\n\nWrites a TUM RGB-D folder (rgb.txt, optional depth.txt and "
      "groundtruth.txt) or a KITTI odometry\nfolder (image_0/, calib.txt, optional poses.txt and times.txt) as a bag "
      "with the topics, frames,\ncamera_info and ground-truth tf of the official TUM bags or of kitti2bag's odometry "
      "bags.";
  const std::vector<Positional> positional = {{"folder", 1, po::value(&folder)}, {"bag", 1, po::value(&bag)}};
  if (!parseCommandLine(arguments, usage, options, positional)) return 0;
  if (folder.empty() || bag.empty()) {
    throw std::invalid_argument("a folder and a bag to write are needed; see dataset_to_bag --help");
  }
  if (camera_info != "openni" && camera_info != "folder") {
    throw std::invalid_argument("--camera-info is '" + camera_info + "'; it must be openni or folder");
  }
  const bool openni = camera_info == "openni" && dataset_options.intrinsics.empty();

  const Dataset dataset = Dataset::open(folder, dataset_options);
  if (writesFactoryCalibration(dataset, openni)) {
    std::cerr << folder << ": camera_info holds the OpenNI driver's factory values (525, 319.5, 239.5, no distortion)"
              << (dataset.intrinsics() ? "" : ", since there is no camera.txt; give the camera's own with --intrinsics")
              << '\n';
  }
  watchInterrupts();
  Progress progress("writing frame", static_cast<int>(dataset.frames().size()));
  exportToBag(dataset, bag, openni, [&progress] { progress.advanceUnlessInterrupted(); });
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return gms_ransac::runProgram(argc, argv, datasetToBag); }
