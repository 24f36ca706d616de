// Turns a TUM or KITTI folder into a bag that looks like the official TUM bags or like kitti2bag's.
#pragma once

#include <functional>
#include <string>

#include "datasets/dataset.h"

namespace gms_ransac {

struct BagExportOptions {
  /// TUM: camera_info as the OpenNI driver reported it (525, 525, 319.5, 239.5, no distortion), which is what the
  /// official bags carry whatever the camera; otherwise what the folder's camera.txt says.
  bool openni_camera_info = true;
  /// KITTI: added to the relative times of times.txt, which ROS would take for "not set". Seconds.
  double kitti_start = 1317042272;  // the day the sequences were recorded
};

/// Colour images, depth at its own stamps and the ground truth at its own rate (TUM); grey images and ground truth
/// (KITTI). `written` is called after each image. Throws DatasetError for input that cannot be turned into a bag and
/// std::runtime_error when the bag cannot be written.
void exportToBag(const Dataset& dataset, const std::string& bag, const BagExportOptions& options,
                 const std::function<void()>& written);

}  // namespace gms_ransac
