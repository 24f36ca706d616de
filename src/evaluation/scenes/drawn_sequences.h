// Drawn sequences of images: features of known points before a camera that moves on, while something passes its view.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "gms_ransac/features.h"

namespace gms_ransac {

enum class CameraPath { kStanding, kDriving, kBraking, kHand };
enum class BodyPath { kCrossing, kStopping, kTowards };

struct DrawnSequence {
  std::string name;
  std::string summary;  ///< what is seen, one line
  CameraPath camera;
  BodyPath body;
  double share;  ///< of the view that the body covers at most
};

/// One image: its features, and the pose of the camera.
struct DrawnImage {
  Features features;                                       ///< of a sceneCamera()
  std::vector<uint8_t> on_body;                            ///< of each keypoint: 1 on the body, 0 on what stands still
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< X_first = pose * X_this, metres
};

constexpr int kSequenceImages = 10;
constexpr double kSequenceInterval = 0.1;  ///< seconds between two images

/// In the order of reading. 1500 points, of which an image shows three quarters; a twentieth of what it shows is up to
/// 48 px from its place.
const std::vector<DrawnSequence>& drawnSequences();

/// The `index`-th sequence of that name, kSequenceImages long: the same one on every machine.
std::vector<DrawnImage> drawSequence(const DrawnSequence& sequence, int index);

}  // namespace gms_ransac
