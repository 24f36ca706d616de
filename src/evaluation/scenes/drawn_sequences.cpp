#include "scenes/drawn_sequences.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "gms_ransac/camera.h"
#include "parameters/parameter.h"
#include "scenes/two_view_scene.h"
#include "support/random.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;
constexpr int kPoints = 1500;        // that the view has room for
constexpr double kDetected = 0.75;   // share of the points in view that become keypoints
constexpr double kMisplaced = 0.05;  // share of these elsewhere,
constexpr double kReach = 48;        // pixels in x and in y at most
constexpr double kFlipped = 0.07;    // share of the bits of a descriptor that an image changes: 33 of a pair's
constexpr double kNoise = 0.3;       // pixels at octave 0
constexpr double kBodyDepth = 0.5;   // metres, of its box

/// A street with its cars, or a room with its people: a box about the first camera, whose walls the camera sees from
/// within. Metres, and metres from image to image.
struct Setting {
  Vector3d low, high;                  // of the box: right, down, forward
  double body_nearest, body_farthest;  // distances of the body when it covers its share
  double slowest, fastest;             // of the body
};
const Setting kStreet = {{-8, -12, -2}, {8, 1.6, 80}, 5, 10, 0.4, 1.5},
              kRoom = {{-2.5, -1.3, -1}, {2.5, 1.2, 5}, 1.2, 2.5, 0.04, 0.15};
constexpr double kRelief = 0.05;  // of the walls: a point is up to that share nearer

const Setting& settingOf(const DrawnSequence& sequence) {
  return sequence.camera == CameraPath::kHand ? kRoom : kStreet;
}

/// The image in which the body covers its share.
int imageOfShare(const DrawnSequence& sequence) {
  return sequence.body == BodyPath::kTowards ? kSequenceImages - 1 : kSequenceImages / 2;
}

struct Point {
  Vector3d place;  // in the first camera's axes, or in the body's
  std::array<uint8_t, kDescriptorBytes> descriptor;
  int octave;
  float angle;

  Point(const Vector3d& where, Random& random)
      : place(where), octave(drawOctave(random)), angle(static_cast<float>(between(0, 360, random))) {
    for (uint8_t& byte : descriptor) byte = static_cast<uint8_t>(random.below(256));
  }
};

const Camera& lens() {
  static const Camera camera = sceneCamera();
  return camera;
}

/// The poses of the camera in all images.
std::vector<Isometry3d> cameraPath(CameraPath path, Random& random) {
  constexpr double kSpeed = 1, kStep = 0.03, kTurn = 1.5 * kDegree;  // metres and radians an image
  constexpr int kBrakes = 6;                                         // images until the car stands
  const double speed = kSpeed * between(0.5, 1.5, random);
  Vector3d step = kStep * inCube(random).normalized(), turn = kTurn * inCube(random).normalized();
  std::vector<Isometry3d> poses(kSequenceImages, Isometry3d::Identity());
  for (int i = 1; i < kSequenceImages; ++i) {
    Isometry3d motion = Isometry3d::Identity();
    if (path == CameraPath::kHand) {
      step += 0.3 * kStep * inCube(random);
      turn += 0.3 * kTurn * inCube(random);
      motion.translation() = step;
      motion.linear() = rotationFromVector(turn);
    } else if (path != CameraPath::kStanding) {
      const double left = path == CameraPath::kBraking ? std::max(0.0, 1 - static_cast<double>(i) / kBrakes) : 1;
      motion.translation() = left * speed * Vector3d(0, 0, 1);
      motion.linear() = rotationFromVector(left * 0.3 * kDegree * inCube(random));
    }
    poses[static_cast<size_t>(i)] = poses[static_cast<size_t>(i) - 1] * motion;
  }
  return poses;
}

/// A box that faces the camera of the image in which it covers its share.
class Body {
 public:
  Body(const DrawnSequence& sequence, const std::vector<Isometry3d>& cameras, Random& random)
      : path_(sequence.body), image_of_share_(imageOfShare(sequence)) {
    const Setting& setting = settingOf(sequence);
    axes_ = cameras[static_cast<size_t>(image_of_share_)];
    const double side = std::sqrt(sequence.share), depth = between(setting.body_nearest, setting.body_farthest, random);
    const cv::Size size = lens().imageSize();
    half_ = 0.5 * depth * Vector2d(size.width, size.height) / lens().meanFocalLength();
    const Vector3d middle = (1 - side) * Vector3d(half_.x(), half_.y(), 0).cwiseProduct(inCube(random));
    middle_ = middle + Vector3d(0, 0, depth);
    half_ *= side;
    const double speed = between(setting.slowest, setting.fastest, random), sign = random.uniform() < 0.5 ? -1 : 1;
    step_ = path_ == BodyPath::kTowards ? Vector3d(0, 0, -speed) : Vector3d(sign * speed, 0, 0);
    const int count = static_cast<int>(kPoints * sequence.share);
    for (int k = 0; k < count; ++k) {
      const Vector3d c = inCube(random);
      points_.emplace_back(Vector3d(c.x() * half_.x(), c.y() * half_.y(), 0.5 * kBodyDepth * c.z()), random);
    }
  }

  const std::vector<Point>& points() const { return points_; }
  /// Where a point of the body is in this image, first camera's axes.
  Vector3d placeOf(const Point& point, int image) const { return axes_ * (centre(image) + point.place); }
  bool hides(const Vector3d& point, const Isometry3d& camera, int image) const {
    // Along the ray to the plane of the box.
    const Vector3d from = axes_.inverse() * camera.translation(), to = axes_.inverse() * point;
    const Vector3d at = centre(image);
    const double share = (at.z() - from.z()) / (to.z() - from.z());
    if (!(share > 0 && share < 1)) return false;
    const Vector3d hit = from + share * (to - from) - at;
    return std::abs(hit.x()) < half_.x() && std::abs(hit.y()) < half_.y();
  }

 private:
  Vector3d centre(int image) const {
    double images = image - image_of_share_;
    if (path_ == BodyPath::kStopping && images > -kStops) {
      images = images < 0 ? -images * images / (2 * kStops) : 0;  // at an even deceleration
    } else if (path_ == BodyPath::kStopping) {
      images += kStops / 2;
    }
    return middle_ + images * step_;
  }

  static constexpr double kStops = 3;  // images in which a body that stops slows down

  BodyPath path_;
  int image_of_share_;
  Isometry3d axes_;  // of the camera of that image
  Vector2d half_;    // sides
  Vector3d middle_, step_;
  std::vector<Point> points_;
};

constexpr double kClosest = 0.3;  // metres before the camera

/// The image of a point, or nothing.
bool project(const Vector3d& point, const Isometry3d& pose, Vector2d& pixel) {
  const Vector3d seen = pose.inverse() * point;
  if (seen.z() < kClosest) return false;
  pixel = (lens().K() * seen).hnormalized();
  const cv::Size size = lens().imageSize();
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < size.width && pixel.y() < size.height;
}

/// A point of the box where a pixel's ray meets it.
Vector3d anywhereInView(const Setting& setting, const Isometry3d& pose, Random& random) {
  const cv::Size size = lens().imageSize();
  const Vector3d pixel(size.width * random.uniform(), size.height * random.uniform(), 1);
  const Vector3d ray = pose.linear() * (lens().K().inverse() * pixel), from = pose.translation();
  double depth = std::numeric_limits<double>::max();
  for (int k = 0; k < 3; ++k) {
    const double wall = ray[k] > 0 ? setting.high[k] : setting.low[k];
    if (ray[k] != 0) depth = std::min(depth, (wall - from[k]) / ray[k]);
  }
  return from + (1 - kRelief * random.uniform()) * depth * ray;
}

void detect(const Point& point, const Vector2d& pixel, Random& random, Features& features,
            std::vector<uint8_t>& descriptors) {
  if (random.uniform() >= kDetected) return;
  const double sigma = noiseAt(point.octave, kNoise);
  Vector2d place = pixel + sigma * Vector2d(gaussian(random), gaussian(random));
  if (random.uniform() < kMisplaced) place += kReach * inCube(random).head<2>();
  const cv::Size size = features.image_size;
  const cv::Point2f at(static_cast<float>(place.x()), static_cast<float>(place.y()));
  if (!isInImage(at.x, size.width) || !isInImage(at.y, size.height)) return;
  features.keypoints.emplace_back(at, 31.f, point.angle, 1.f, point.octave);
  for (uint8_t byte : point.descriptor) {
    for (int bit = 0; bit < 8; ++bit) byte ^= static_cast<uint8_t>((random.uniform() < kFlipped) << bit);
    descriptors.push_back(byte);
  }
}

std::vector<DrawnSequence> makeSequences() {
  const struct {
    const char *name, *summary;
    CameraPath path;
  } cameras[] = {{"standing", "a camera that stands", CameraPath::kStanding},
                 {"driving", "a camera that drives on", CameraPath::kDriving},
                 {"braking", "a camera that brakes and stands", CameraPath::kBraking},
                 {"hand", "a camera in a hand", CameraPath::kHand}};
  const struct {
    const char *name, *summary;
    BodyPath path;
  } bodies[] = {{"crossing", "crosses the view", BodyPath::kCrossing},
                {"stopping", "comes and stops", BodyPath::kStopping},
                {"towards", "comes towards it", BodyPath::kTowards}};
  std::vector<DrawnSequence> sequences;
  for (const auto& camera : cameras) {
    for (const auto& body : bodies) {
      for (const double percent : {10, 20, 40, 60}) {
        sequences.push_back(
            {std::string("sequence_") + camera.name + "_" + body.name + "_" + toText(percent),
             std::string(camera.summary) + ", a body on at most " + toText(percent) + " % of the view " + body.summary,
             camera.path, body.path, percent / 100});
      }
    }
  }
  return sequences;
}

}  // namespace

const std::vector<DrawnSequence>& drawnSequences() {
  static const std::vector<DrawnSequence> sequences = makeSequences();
  return sequences;
}

std::vector<DrawnImage> drawSequence(const DrawnSequence& sequence, int index) {
  Random random(static_cast<uint64_t>(index) + 1);
  const std::vector<Isometry3d> poses = cameraPath(sequence.camera, random);
  const Setting& setting = settingOf(sequence);
  const Body body(sequence, poses, random);
  std::vector<Point> scene;
  scene.reserve(kPoints);
  for (int k = 0; k < kPoints; ++k) scene.emplace_back(anywhereInView(setting, poses.front(), random), random);
  std::vector<DrawnImage> images(kSequenceImages);
  for (int i = 0; i < kSequenceImages; ++i) {
    DrawnImage& image = images[static_cast<size_t>(i)];
    image.pose = poses[static_cast<size_t>(i)];
    image.features.image_size = lens().imageSize();
    std::vector<uint8_t> descriptors;
    Vector2d pixel;
    for (Point& point : scene) {
      // A point that has left the view makes room for another one.
      if (!project(point.place, image.pose, pixel)) {
        point = Point(anywhereInView(setting, image.pose, random), random);
        project(point.place, image.pose, pixel);
      }
      if (!body.hides(point.place, image.pose, i)) detect(point, pixel, random, image.features, descriptors);
    }
    image.on_body.assign(image.features.keypoints.size(), 0);
    for (const Point& point : body.points()) {
      if (project(body.placeOf(point, i), image.pose, pixel)) detect(point, pixel, random, image.features, descriptors);
    }
    image.on_body.resize(image.features.keypoints.size(), 1);
    image.features.descriptors.assign(cv::Mat(image.features.size(), kDescriptorBytes, CV_8U, descriptors.data()));
  }
  return images;
}

}  // namespace gms_ransac
