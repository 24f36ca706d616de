#include "scenes/two_view_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "support/random.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kWidth = 640, kHeight = 480;  // pixels
constexpr double kFocalLength = 500;        // pixels
constexpr int kLevels = 8;
constexpr double kBackground = 300, kBackgroundEnd = 1000;  // metres: hills and clouds behind a scene
constexpr double kLevelScale = 1.2, kNoiseExponent = 0.5;   // noise of a keypoint by octave, doc/measured/constants.md

// Hamming distance to the nearest and the second, and score, of right and wrong matches that GMS kept. Mean and
// deviation over KITTI, Oxford and Middlebury pairs, labelled by their truth within 3 px.
struct Normal {
  double mean, deviation;
};
constexpr Normal kRightDistance = {34, 14}, kWrongDistance = {51, 13};
constexpr Normal kRightSecond = {53, 14}, kWrongSecond = {56, 12};
constexpr Normal kRightScore = {22, 12}, kWrongScore = {18, 12};
constexpr int kScoreThreshold = 10, kLargestScore = 50;
constexpr int kOutlier = -1, kStatic = 0;
constexpr int kRowIterations = 4;      // until a point knows its row: the error falls by a hundred in each
constexpr int kScalingIterations = 3;  // displacement is nearly proportional to the translation
constexpr int kMeasuredMatches = 1000;

bool isInside(const Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.x() < kWidth && pixel.y() >= 0 && pixel.y() < kHeight;
}

/// The lens that draws, which the calibration may be wrong about.
class Lens {
 public:
  explicit Lens(const TwoViewSceneOptions& options) : radial_(options.radial) {
    K_ = sceneCamera().K();
    K_.topLeftCorner<2, 2>() *= 1 + options.focal_error;
    K_inverse_ = K_.inverse();
  }
  /// The ray that an undistorted lens would see at that pixel.
  Vector3d ray(const Vector2d& pixel) const { return K_inverse_ * pixel.homogeneous(); }
  Vector2d project(const Vector3d& point) const {
    const Vector2d ideal = point.hnormalized();
    const double r2 = ideal.squaredNorm();
    const Vector2d distorted = ideal * (1 + r2 * (radial_[0] + r2 * radial_[1]));
    return (K_ * distorted.homogeneous()).head<2>();
  }

 private:
  Matrix3d K_, K_inverse_;
  Vector2d radial_;
};

/// The motion from image to image, X_current = R X_reference + t.
struct Motion {
  Matrix3d R;
  Vector3d t;
  Vector3d rotation;      ///< rotation vector of R
  bool straight = false;  ///< TwoViewSceneOptions::straight

  Motion(const Vector3d& rotation_vector, const Vector3d& translation)
      : R(rotationFromVector(rotation_vector)), t(translation), rotation(rotation_vector) {}
  Motion(const Matrix3d& matrix, const Vector3d& translation)
      : R(matrix), t(translation), rotation(rotationVector(matrix)) {}
  /// Where a point is, that was at X when this motion began, after a share of it.
  Vector3d after(double share, const Vector3d& X) const {
    return rotationFromVector(share * rotation) * X + share * wayAfter(share);
  }
  /// The reverse.
  Vector3d before(double share, const Vector3d& X) const {
    return rotationFromVector(share * rotation).transpose() * (X - share * wayAfter(share));
  }

 private:
  /// The way of the whole motion, in the axes that the camera has after a share of it.
  Vector3d wayAfter(double share) const { return straight ? rotationFromVector((share - 1) * rotation) * t : t; }
};

/// The static scene and the bodies, each with its motion relative to the camera.
class Layout {
 public:
  explicit Layout(const TwoViewSceneOptions& options) : options_(options), random_(~options.seed) {
    motions_.emplace_back(options.rotation, options.translation);
    motions_.front().straight = options.straight;
    for (const MovingBody& body : options.bodies) {
      const double side = std::sqrt(body.share);
      const double x = kWidth * (side / 2 + (1 - side) * random_.uniform());
      const double y = kHeight * (side / 2 + (1 - side) * random_.uniform());
      centres_.emplace_back(x, y);
      const Vector3d centre = Lens(options_).ray(centres_.back()) * (body.nearest + body.farthest) / 2;
      const Matrix3d R = rotationFromVector(body.rotation);
      const Motion& camera = motions_.front();
      motions_.emplace_back(Matrix3d(camera.R * R), camera.R * (centre - R * centre + body.translation) + camera.t);
    }
  }

  const Motion& motion(int body) const { return motions_[static_cast<size_t>(body)]; }

  int bodyAt(const Vector2d& pixel) {
    for (size_t k = 0; k < options_.bodies.size(); ++k) {
      const MovingBody& body = options_.bodies[k];
      const Vector2d off = (pixel - centres_[k]).cwiseAbs();
      const double side = std::sqrt(body.share) / 2;
      const bool covers =
          body.everywhere ? random_.uniform() < body.share : off.x() < side * kWidth && off.y() < side * kHeight;
      if (covers) return static_cast<int>(k) + 1;
    }
    return kStatic;
  }

  /// Returns true for a body in front of the scene, false for a part of the scene.
  bool isBefore(int body) const {
    return body != kStatic && !options_.bodies[static_cast<size_t>(body) - 1].everywhere;
  }

  /// Depth of the volume or of a body, `share` of the way from the nearest to the farthest.
  double depthIn(int body, double share) const {
    if (isBefore(body)) {
      const MovingBody& moving = options_.bodies[static_cast<size_t>(body) - 1];
      return moving.nearest + share * (moving.farthest - moving.nearest);
    }
    if (share < options_.background) {
      const double farther = share / options_.background;
      return kBackground + farther * (kBackgroundEnd - kBackground);
    }
    share = (share - options_.background) / (1 - options_.background);
    if (!options_.mostly_near) return options_.nearest + share * (options_.farthest - options_.nearest);
    return 1 / (1 / options_.nearest + share * (1 / options_.farthest - 1 / options_.nearest));
  }

 private:
  const TwoViewSceneOptions& options_;
  Random random_;                  ///< of its own: scenes without bodies do not depend on it
  std::vector<Motion> motions_;    ///< of what stands still, then of each body
  std::vector<Vector2d> centres_;  ///< of each body's window, pixels
};

/// Share of the motion that is done when a row of the image taken at `start` (0: the reference, 1: the current) is
/// read.
double shareAt(const TwoViewSceneOptions& options, double start, double row) {
  const double time = start + options.readout * (row / kHeight - 0.5);
  return time * (1 + options.acceleration * (time - 1));
}

/// Position in the current image of a point in the frame of the reference camera at its row's time; false: behind.
bool seenByCurrent(const TwoViewSceneOptions& options, const Lens& lens, const Motion& motion, double row,
                   const Vector3d& point, Vector2d& pixel) {
  const bool global = options.readout == 0;
  const Vector3d start = global ? point : motion.before(shareAt(options, 0, row), point);
  double share = 1;
  for (int i = 0; i < (global ? 1 : kRowIterations); ++i) {
    const Vector3d moved = motion.after(share, start);
    if (moved.z() <= 0) return false;
    pixel = lens.project(moved);
    share = shareAt(options, 1, pixel.y());
  }
  return true;
}

Vector2d outlierPlace(const TwoViewSceneOptions& options, const Vector2d& right, Random& random) {
  if (options.outlier_reach == 0) return {kWidth * random.uniform(), kHeight * random.uniform()};
  const Vector2d share{2 * random.uniform() - 1, 2 * random.uniform() - 1};
  return right + options.outlier_reach * share;
}

double draw(const Normal& normal, Random& random) { return normal.mean + normal.deviation * gaussian(random); }

void describeAsMeasured(bool looks_right, bool repeated, Random& random, size_t i, PointPairs& columns) {
  const double distance = std::clamp(draw(looks_right ? kRightDistance : kWrongDistance, random), 0., 256.);
  const double second = repeated ? distance * (1 + 0.1 * random.uniform())
                                 : std::clamp(draw(looks_right ? kRightSecond : kWrongSecond, random), distance, 256.);
  columns.distance[i] = static_cast<uint16_t>(distance);
  columns.second_distance[i] = static_cast<uint16_t>(std::min(256., second));
  columns.score[i] = static_cast<int32_t>(
      std::clamp<double>(draw(looks_right ? kRightScore : kWrongScore, random), kScoreThreshold, kLargestScore));
  columns.relative_score[i] = static_cast<float>(columns.score[i]) / kScoreThreshold;
}

/// Columns of match i apart from its places.
void describeMatch(const TwoViewSceneOptions& options, bool outlier, Random& random, size_t i, PointPairs& columns) {
  if (options.as_measured) {
    return describeAsMeasured(!options.informative || !outlier, !options.informative, random, i, columns);
  }
  const double quality = (options.informative && !outlier ? 1 : 0) + gaussian(random);
  columns.score[i] = std::max(0, static_cast<int>(30 + 10 * quality));
  columns.relative_score[i] = static_cast<float>(columns.score[i]) / 15;
  columns.distance[i] = static_cast<uint16_t>(std::min(256., std::max(0., 60 - 15 * quality)));
  columns.second_distance[i] = static_cast<uint16_t>(columns.distance[i] + random.below(20));
}

/// Takes the motion that most matches follow for the truth.
void settleTruth(const TwoViewSceneOptions& options, const Layout& layout, const Lens& lens, TwoViewScene& scene) {
  std::vector<int> counts(options.bodies.size() + 1, 0);
  for (const int body : scene.body) {
    if (body != kOutlier) ++counts[static_cast<size_t>(body)];
  }
  const auto largest = static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  scene.R = layout.motion(largest).R;
  scene.t = layout.motion(largest).t;
  const Vector2d nowhere = Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (size_t i = 0; i < scene.body.size(); ++i) {
    scene.correct[i] = scene.body[i] == largest;
    const Vector2d reference = lens.project(scene.points[i]);
    Vector2d current;
    const bool seen = seenByCurrent(options, lens, layout.motion(largest), reference.y(), scene.points[i], current);
    scene.displacements[i] = seen ? Vector2d(current - reference) : nowhere;
  }
}

/// Median displacement in pixels of the static points, seen without noise by a camera that only translates. With
/// `rotation_undone`, what the small rotation of the least-squares fit explains is subtracted first.
double medianMotion(TwoViewSceneOptions options, bool rotation_undone) {
  options.matches = kMeasuredMatches;
  options.outlier_ratio = options.noise_px = options.readout = options.focal_error = 0;
  options.radial.setZero();
  options.rotation.setZero();
  options.bodies.clear();
  const TwoViewScene scene = makeTwoViewScene(options);
  const PointPairs& pairs = scene.pairs;
  std::vector<Vector2d> motions;
  std::vector<Eigen::Matrix<double, 2, 3>> derivatives;  // of a pixel by a small rotation of its point about the camera
  Matrix3d A = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (size_t i = 0; i < scene.points.size(); ++i) {
    const double x = scene.points[i].x() / scene.points[i].z(), y = scene.points[i].y() / scene.points[i].z();
    motions.emplace_back(pairs.x_current[i] - pairs.x_reference[i], pairs.y_current[i] - pairs.y_reference[i]);
    Eigen::Matrix<double, 2, 3>& J = derivatives.emplace_back();
    J << -x * y, 1 + x * x, -y, -(1 + y * y), x * y, x;
    J *= kFocalLength;
    A += J.transpose() * J;
    b += J.transpose() * motions[i];
  }
  const Vector3d rotation = rotation_undone ? Vector3d(A.ldlt().solve(b)) : Vector3d(0, 0, 0);
  std::vector<double> lengths;
  for (size_t i = 0; i < motions.size(); ++i) lengths.push_back((motions[i] - derivatives[i] * rotation).norm());
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

}  // namespace

Camera sceneCamera() {
  return Camera({kFocalLength, kFocalLength, kWidth / 2.0, kHeight / 2.0, "", {}}, {kWidth, kHeight});
}

double between(double low, double high, Random& random) { return low + (high - low) * random.uniform(); }

Vector3d inCube(Random& random) {
  const double x = between(-1, 1, random), y = between(-1, 1, random), z = between(-1, 1, random);
  return {x, y, z};
}

int drawOctave(Random& random) { return static_cast<int>(kLevels * random.uniform() * random.uniform()); }

double noiseAt(int octave, double noise_px) { return noise_px * std::pow(kLevelScale, kNoiseExponent * octave); }

double gaussian(Random& random) {
  const double u = random.uniform(), v = random.uniform();
  return std::sqrt(-2 * std::log(1 - u)) * std::cos(2 * M_PI * v);
}

TwoViewScene makeTwoViewScene(const TwoViewSceneOptions& options) {
  TwoViewScene scene;
  scene.camera = sceneCamera();
  const bool planar = options.shape == SceneShape::kPlane;
  scene.plane = planar ? Vector3d(options.plane_normal / options.plane_distance) : Vector3d(0, 0, 0);
  PointPairs& columns = scene.pairs;
  columns.resize(options.matches);
  columns.image_reference = columns.image_current = {kWidth, kHeight};
  columns.seconds = kSceneInterval;
  const auto n = static_cast<size_t>(options.matches);
  scene.body.resize(n);
  scene.correct.resize(n);
  scene.points.resize(n);
  scene.displacements.resize(n);

  const Lens lens(options);
  Layout layout(options);
  Random random(options.seed);
  const auto about = [&](double length) { return length * (0.5 + options.image_share * (random.uniform() - 0.5)); };
  for (size_t i = 0; i < scene.body.size();) {
    const bool outlier = random.uniform() < options.outlier_ratio;
    const Vector2d place(about(kWidth), about(kHeight));
    const Vector3d ray = lens.ray(place);
    const int body = layout.bodyAt(place);
    const bool on_plane =
        planar && !layout.isBefore(body) && !(options.off_plane > 0 && random.uniform() < options.off_plane);
    const double depth = on_plane ? 1 / scene.plane.dot(ray) : layout.depthIn(body, random.uniform());
    const Vector2d reference = lens.project(ray);
    Vector2d current;
    if (!(depth > 0) || !isInside(reference) ||
        !seenByCurrent(options, lens, layout.motion(body), reference.y(), depth * ray, current) || !isInside(current)) {
      continue;
    }
    if (outlier) current = outlierPlace(options, current, random);
    if (!isInside(current)) continue;
    const int octave = options.octaves ? drawOctave(random) : 0;
    const double sigma = noiseAt(octave, options.noise_px);
    columns.x_reference[i] = static_cast<float>(reference.x() + sigma * gaussian(random));
    columns.y_reference[i] = static_cast<float>(reference.y() + sigma * gaussian(random));
    columns.x_current[i] = static_cast<float>(current.x() + sigma * gaussian(random));
    columns.y_current[i] = static_cast<float>(current.y() + sigma * gaussian(random));
    columns.octave_reference[i] = columns.octave_current[i] = static_cast<uint8_t>(octave);
    describeMatch(options, outlier, random, i, columns);
    scene.points[i] = depth * ray;
    scene.body[i] = outlier ? kOutlier : body;
    ++i;
  }
  settleTruth(options, layout, lens, scene);
  return scene;
}

double medianDisplacement(const TwoViewSceneOptions& options) { return medianMotion(options, false); }
double medianParallax(const TwoViewSceneOptions& options) { return medianMotion(options, true); }

TwoViewSceneOptions withMedian(double (*measure)(const TwoViewSceneOptions&), double pixels,
                               TwoViewSceneOptions options) {
  for (int i = 0; i < kScalingIterations; ++i) options.translation *= pixels / measure(options);
  return options;
}

}  // namespace gms_ransac
