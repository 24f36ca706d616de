// Writes a TUM or KITTI folder as a bag with the layout of the official TUM bags or of kitti2bag.
#pragma once

#include <functional>
#include <string>

#include "datasets/dataset.h"

namespace gms_ransac {

struct BagExportOptions {
  /// TUM, images of 640 x 480: openNiIntrinsics() in camera_info, as in the official bags. Otherwise the calibration of
  /// the folder, if there is one.
  bool openni_camera_info = false;
  /// KITTI: added to the relative times of times.txt, which ROS would take for "not set". Seconds.
  double kitti_start = 1317042272;  // the day the sequences were recorded
};

/// Returns true if camera_info will hold openNiIntrinsics().
bool writesFactoryCalibration(const Dataset& dataset, const BagExportOptions& options);

/// Colour images, depth at its own stamps and the ground truth at its own rate (TUM); grey images and ground truth
/// (KITTI). `written` is called after each image. Throws DatasetError for input that cannot be turned into a bag and
/// std::runtime_error when the bag cannot be written.
void exportToBag(const Dataset& dataset, const std::string& bag, const BagExportOptions& options,
                 const std::function<void()>& written);

}  // namespace gms_ransac
