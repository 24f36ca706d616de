// Two views of known points, drawn and not rendered: matches with exact truth, from well-posed motions to difficult
// ones (moving bodies, repetition, rolling shutter, wrong calibration).
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "gms_ransac/camera.h"
#include "gms_ransac/point_pairs.h"

namespace gms_ransac {

class Random;

enum class SceneShape { kVolume, kPlane };

/// Something rigid that moves by itself: X -> R (X - centre) + centre + translation, metres, in the reference frame.
struct MovingBody {
  double share = 0;                      ///< of the reference image: a window of its proportions, anywhere in it
  Eigen::Vector3d translation{0, 0, 0};  ///< metres
  Eigen::Vector3d rotation{0, 0, 0};     ///< rotation vector about the middle of the body, radians
  double nearest = 3, farthest = 4.5;    ///< depths, metres; before what stands still
  bool everywhere = false;               ///< no window: every point of the scene belongs to it with that probability
};

struct TwoViewSceneOptions {
  int matches = 1000;
  double outlier_ratio = 0.3;
  double outlier_reach = 0;  ///< an outlier ends so far from its place at most, in x and in y, pixels; 0: anywhere
  double noise_px = 0.3;     ///< standard deviation in each coordinate of each image
  SceneShape shape = SceneShape::kVolume;
  Eigen::Vector3d translation{0.4, -0.1, 0.25};  ///< X_current = R X_reference + translation, metres
  Eigen::Vector3d rotation{0.02, -0.06, 0.03};   ///< rotation vector of that R, radians
  Eigen::Vector3d plane_normal{0.3, -0.2, 1};    ///< in the reference frame; tilted: its homography is no similarity
  double plane_distance = 8;                     ///< metres along that normal
  double off_plane = 0;                          ///< share of the points of a plane scene that the volume has instead
  double nearest = 4, farthest = 12;             ///< depths of the volume, metres
  bool mostly_near = false;                      ///< these are uniform in the inverse of the depth, not in the depth
  double background = 0;                         ///< share of the points that lie 300 to 1000 m away, behind the volume
  double image_share = 1;  ///< of each side of the reference image that shows points, about its middle
  bool octaves = false;  ///< keypoints of all eight levels of a pyramid, the coarse less accurate; otherwise of level 0
  bool informative = true;   ///< score and distance tell outliers from the rest, with overlap; otherwise they are noise
  bool as_measured = false;  ///< by as much as ORB's do among the matches that GMS keeps of real images; else by more
  std::vector<MovingBody> bodies;  ///< their matches are as good as others; where windows overlap the first is in front
  /// Rolling shutter: share of the time between images, kSceneInterval. Rotation and translation are from middle row to
  /// middle row. 0: global shutter.
  double readout = 0;
  bool straight = false;    ///< straight path between the images; else one that bends with the rotation
  double acceleration = 0;  ///< the camera has 1 - this of its mean speed at the reference and 1 + this at the current
  double focal_error = 0;   ///< the lens has the focal length of sceneCamera() times 1 + this
  Eigen::Vector2d radial{0, 0};  ///< k1 and k2 of distortion that nobody has undone
  uint64_t seed = 1;
};

struct TwoViewScene {
  Camera camera;  ///< as it is calibrated, which `focal_error` and `radial` make wrong
  PointPairs pairs;
  std::vector<int> body;                ///< of each match: 0 stands still, k is options.bodies[k - 1], -1 an outlier
  std::vector<uint8_t> correct;         ///< of each match: it follows R and t
  std::vector<Eigen::Vector3d> points;  ///< point of each match, in the reference frame
  /// True displacement of each point that follows R and t, pixels: through the true lens, at the times of its rows,
  /// without noise. NaN behind the camera.
  std::vector<Eigen::Vector2d> displacements;
  /// X_current = R X_reference + t of the points that most matches show: the camera's motion, or that relative to a
  /// body which more of them show.
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  Eigen::Vector3d plane;  ///< its points X have plane . X = 1, in the reference frame; zero for a volume

  /// Pose of the current camera in the reference frame.
  Eigen::Isometry3d currentInReference() const {
    Eigen::Isometry3d pose(R.transpose());
    pose.translation() = -R.transpose() * t;
    return pose;
  }
};

constexpr double kSceneInterval = 1 / 30.;  ///< from the reference to the current image, seconds

/// 640 x 480 pixels, f = 500 px.
Camera sceneCamera();

/// Points that both images of a sceneCamera() show.
TwoViewScene makeTwoViewScene(const TwoViewSceneOptions& options);

/// Median displacement of the static points by the translation alone, pixels.
double medianDisplacement(const TwoViewSceneOptions& options);
/// The same after subtracting the best rotation in the sense of least squares.
double medianParallax(const TwoViewSceneOptions& options);
/// Scales the translation so that one of these medians is `pixels`.
TwoViewSceneOptions withMedian(double (*measure)(const TwoViewSceneOptions&), double pixels,
                               TwoViewSceneOptions options);

// Random numbers of drawn scenes and sequences.
double gaussian(Random& random);                          ///< standard normal
double between(double low, double high, Random& random);  ///< uniform
Eigen::Vector3d inCube(Random& random);                   ///< uniform in -1..1 along each axis
int drawOctave(Random& random);                           ///< of eight, the coarse less often
/// Standard deviation of a coordinate of a keypoint that has `noise_px` at octave 0 (doc/measured/constants.md).
double noiseAt(int octave, double noise_px);

}  // namespace gms_ransac
