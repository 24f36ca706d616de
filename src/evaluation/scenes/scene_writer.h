// Writes a rendered sequence as a folder in TUM layout or as a bag with the topics of the official TUM bags.
#pragma once

#include <functional>
#include <string>

#include "scenes/scene.h"

namespace gms_ransac {

/// Folder (made if missing) with rgb/, rgb.txt, depth/ (16-bit PNG, 5000 to the metre, 0 unknown), depth.txt,
/// groundtruth.txt and camera.txt; imu.csv, in the columns of EuRoC, if the scene has an IMU. `written` is called after
/// each frame. Throws std::runtime_error naming the file that cannot be written.
void writeTumFolder(const Scene& scene, int frames, const std::string& folder, const std::function<void()>& written);

/// Colour (or grey), depth, camera_info and ground-truth tf; see BagLayout::kTum. With an IMU also /imu, and its place
/// on the camera in /tf.
void writeBag(const Scene& scene, int frames, const std::string& path, const std::function<void()>& written);

}  // namespace gms_ransac
