#include "scenes/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "camera/distortion.h"
#include "support/validation.h"

namespace gms_ransac {

namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kOpenNiFocalLength = 525.0 / 640;  // per pixel of width
constexpr double kRoomStep = 0.08, kStreetStep = 0.3;
constexpr double kStreetHeight = 1.6;  // metres, of the camera
constexpr double kStreetStart = 3, kStreetEnd = kStreetLength - 12;
constexpr int kExposures = 8;  // instants that an exposure is made of
constexpr double kMoverWidth = 0.7, kMoverHeight = 1.3, kMoverDistance = 2.2, kMoverGap = 1.1;  // metres
constexpr double kMoverSway = 0.35, kMoverPeriod = 43;  // metres to each side, frames: at most 5 cm a frame
constexpr int kSamplesPerSide = 2;        // of a pixel: 2 x 2 rays, so that silhouettes do not make stair-case corners
constexpr double kNear = 0.05;            // metres; nothing in the scenes comes closer
constexpr double kOcclusionSlack = 1e-4;  // relative depth: rounding, not geometry

double radians(double degrees) { return degrees * M_PI / 180; }
double wave(double x, double period, double phase = 0) { return std::sin(2 * M_PI * (x / period + phase)); }

/// Orientation of a camera looking along `heading` (from x towards y) and `elevation`, rolled about its axis; radians.
Matrix3d lookAlong(double heading, double elevation, double roll) {
  const Vector3d forward(std::cos(heading) * std::cos(elevation), std::sin(heading) * std::cos(elevation),
                         std::sin(elevation));
  const Vector3d right(std::sin(heading), -std::cos(heading), 0);
  Matrix3d R;
  R << right, forward.cross(right), forward;
  return R * Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix();
}

/// A surface in the camera frame. For the ray d = (x, y, 1): inverse depth = inverse_depth . d, and the texture
/// position is (u . d, v . d) * depth + offset.
struct ProjectedSurface {
  int index;
  Eigen::Vector3f inverse_depth, u, v;
  float u_offset, v_offset, width, height;
  float x_min, x_max, y_min, y_max;  ///< bounds of the rays that can meet it
};

bool projectSurface(const Surface& surface, const Isometry3d& pose, ProjectedSurface& out) {
  const Vector3d centre = pose.translation();
  const double distance = surface.normal.dot(surface.corner - centre);
  if (distance >= 0) return false;  // seen from behind
  const Matrix3d to_camera = pose.linear().transpose();

  constexpr float kInfinite = std::numeric_limits<float>::max();
  out.x_min = out.y_min = kInfinite;
  out.x_max = out.y_max = -kInfinite;
  int in_front = 0;
  for (int k = 0; k < 4; ++k) {
    const Vector3d corner =
        surface.corner + (k & 1 ? surface.width : 0) * surface.u + (k & 2 ? surface.height : 0) * surface.v;
    const Vector3d p = to_camera * (corner - centre);
    if (p.z() < kNear) continue;
    ++in_front;
    const float x = static_cast<float>(p.x() / p.z()), y = static_cast<float>(p.y() / p.z());
    out.x_min = std::min(out.x_min, x);
    out.x_max = std::max(out.x_max, x);
    out.y_min = std::min(out.y_min, y);
    out.y_max = std::max(out.y_max, y);
  }
  if (in_front == 0) return false;
  if (in_front < 4) {  // crosses the image plane: no bound
    out.x_min = out.y_min = -kInfinite;
    out.x_max = out.y_max = kInfinite;
  }
  out.inverse_depth = (to_camera * surface.normal / distance).cast<float>();
  out.u = (to_camera * surface.u).cast<float>();
  out.v = (to_camera * surface.v).cast<float>();
  out.u_offset = static_cast<float>(surface.u.dot(centre - surface.corner));
  out.v_offset = static_cast<float>(surface.v.dot(centre - surface.corner));
  out.width = static_cast<float>(surface.width);
  out.height = static_cast<float>(surface.height);
  return true;
}

/// The nearest surface of each ray of a row.
struct RowHits {
  std::vector<float> inverse_depth, u, v;
  std::vector<int> surface;  ///< index into the projected surfaces, -1: none
  explicit RowHits(int columns) : inverse_depth(columns), u(columns), v(columns), surface(columns) {}
};

void castRow(const std::vector<ProjectedSurface>& surfaces, const cv::Vec2f* rays, int columns,
             const cv::Vec2f& y_range, RowHits& hits) {
  std::fill(hits.inverse_depth.begin(), hits.inverse_depth.end(), 0.f);
  std::fill(hits.surface.begin(), hits.surface.end(), -1);
  for (size_t k = 0; k < surfaces.size(); ++k) {
    const ProjectedSurface& s = surfaces[k];
    if (y_range[1] < s.y_min || y_range[0] > s.y_max) continue;
    const auto left_of = [](const cv::Vec2f& ray, float x) { return ray[0] < x; };
    const int first = static_cast<int>(std::lower_bound(rays, rays + columns, s.x_min, left_of) - rays);
    for (int c = first; c < columns && rays[c][0] <= s.x_max; ++c) {
      const float x = rays[c][0], y = rays[c][1];
      const float inverse_depth = s.inverse_depth[0] * x + s.inverse_depth[1] * y + s.inverse_depth[2];
      if (inverse_depth <= hits.inverse_depth[c]) continue;
      const float depth = 1 / inverse_depth;
      const float u = (s.u[0] * x + s.u[1] * y + s.u[2]) * depth + s.u_offset;
      const float v = (s.v[0] * x + s.v[1] * y + s.v[2]) * depth + s.v_offset;
      if (u < 0 || v < 0 || u > s.width || v > s.height) continue;
      hits.inverse_depth[c] = inverse_depth;
      hits.u[c] = u;
      hits.v[c] = v;
      hits.surface[c] = static_cast<int>(k);
    }
  }
}

void addNoise(double sigma, uint64_t seed, cv::Mat& image) {
  if (sigma <= 0) return;
  cv::Mat noise(image.size(), CV_MAKETYPE(CV_16S, image.channels()));
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, sigma);
  cv::add(image, noise, image, cv::noArray(), image.depth());
}

}  // namespace

void SceneOptions::validate() const {
  if (scene != "room" && scene != "street") {
    throw std::invalid_argument("scene is '" + scene + "'; it must be room or street");
  }
  requireInRange("image width", size.width, 16, 8192);
  requireInRange("image height", size.height, 16, 8192);
  requireInRange("focal_length", focal_length, 0.0, 1e5);
  requireInRange("step", step, -1.0, 10.0);
  requireInRange("turn", turn, -180.0, 180.0);
  requireInRange("sway", sway, 0.0, 3.0);
  requireInRange("offset", offset, -2.0, 2.0);
  requireInRange("rate", rate, 0.1, 1000.0);
  requireInRange("noise", noise, 0.0, 100.0);
  requireInRange("blur", blur, 0.0, 20.0);
  requireInRange("movers", movers, 0, 20);
  requireInRange("repetition", repetition, 0.0, 100.0);
  requireInRange("readout", readout, 0.0, 1.0);
  requireInRange("exposure", exposure, 0.0, 1.0);
  requireInRange("brightness", brightness, 0.0, 1.0);
  imu.validate();
}

Scene::Scene(const SceneOptions& options) : options_(options) {
  options_.validate();
  if (options_.step < 0) options_.step = options_.scene == "room" ? kRoomStep : kStreetStep;
  if (options_.focal_length == 0) options_.focal_length = kOpenNiFocalLength * options_.size.width;
  intrinsics_.fx = intrinsics_.fy = options_.focal_length;
  intrinsics_.cx = 0.5 * (options_.size.width - 1);
  intrinsics_.cy = 0.5 * (options_.size.height - 1);
  intrinsics_.distortion_model = "plumb_bob";
  intrinsics_.distortion = options_.distortion;
  intrinsics_.validate();
  if (!options_.distortion.empty()) lens_ = std::make_shared<Distortion>(intrinsics_);

  const std::shared_ptr<const Trajectory>& trajectory = options_.trajectory;
  if (options_.scene == "street") {
    surfaces_ = streetSurfaces(options_.seed);
    if (trajectory) trajectory_in_scene_ = placeInStreet(*trajectory, {kStreetStart, 0, kStreetHeight});
  } else if (trajectory) {
    trajectory_in_scene_ = placeInHall(*trajectory);
    surfaces_ = hallSurfaces(options_.seed, placesAlong(*trajectory, trajectory_in_scene_));
  } else {
    surfaces_ = roomSurfaces(options_.seed);
  }
  const Vector3d placed_later = Vector3d::Zero();
  const Surface mover = {placed_later,          placed_later, placed_later, placed_later, kMoverWidth, kMoverHeight, 1,
                         TextureStyle::kBricks, {1, 1, 1},    0.004};
  surfaces_.insert(surfaces_.end(), static_cast<size_t>(options_.movers), mover);
  for (size_t i = 0; i < surfaces_.size(); ++i) {
    const Surface& s = surfaces_[i];
    textures_.emplace_back(s.style, s.width, s.height, s.texel, options_.seed * 1000 + i + 1);
  }
  samples_ = makeRays(kSamplesPerSide);
  centres_ = makeRays(1);
}

Vector2d Scene::ray(const cv::Point2d& pixel) const {
  const Vector2d seen((pixel.x - intrinsics_.cx) / intrinsics_.fx, (pixel.y - intrinsics_.cy) / intrinsics_.fy);
  Vector2d ideal = seen;
  if (lens_ && !lens_->undistort(seen, ideal)) throw std::invalid_argument("distortion has no inverse in the image");
  return ideal;
}

cv::Point2d Scene::project(const Vector3d& point) const {
  Vector2d p = point.head<2>() / point.z();
  if (lens_) p = lens_->distort(p);
  return {intrinsics_.fx * p.x() + intrinsics_.cx, intrinsics_.fy * p.y() + intrinsics_.cy};
}

Scene::RayGrid Scene::makeRays(int samples) const {
  RayGrid grid;
  grid.rays.create(options_.size.height * samples, options_.size.width * samples);
  for (int r = 0; r < grid.rays.rows; ++r) {
    cv::Vec2f range(std::numeric_limits<float>::max(), -std::numeric_limits<float>::max());
    for (int c = 0; c < grid.rays.cols; ++c) {
      const Vector2d d = ray({(c + 0.5) / samples - 0.5, (r + 0.5) / samples - 0.5});
      grid.rays(r, c) = cv::Vec2f(static_cast<float>(d.x()), static_cast<float>(d.y()));
      range = {std::min(range[0], grid.rays(r, c)[1]), std::max(range[1], grid.rays(r, c)[1])};
    }
    grid.y_range.push_back(range);
  }
  return grid;
}

int Scene::frameCount() const {
  if (options_.trajectory) {  // a rolling shutter, an exposure and the IMU need a frame's time at both ends
    constexpr double kRounding = 1e-6;
    const double seconds = options_.trajectory->end() - options_.trajectory->begin();
    return std::max(0, static_cast<int>(std::floor(seconds * options_.rate + kRounding)) - 1);
  }
  if (options_.scene == "room" || options_.step == 0) return std::numeric_limits<int>::max();
  return static_cast<int>((kStreetEnd - kStreetStart) / options_.step) + 1;
}

Isometry3d Scene::pose(int index) const {
  if (index < 0 || index >= frameCount()) {
    throw std::invalid_argument("frame " + std::to_string(index) + " is outside the scene's path of " +
                                std::to_string(frameCount()) + " frames");
  }
  return poseAt(index);
}

Isometry3d Scene::poseAt(double time) const {
  Isometry3d pose = pathAt(time);
  pose.translation() += options_.offset * pose.linear().col(0);
  return pose;
}

Isometry3d Scene::pathAt(double time) const {
  if (options_.trajectory) {
    return trajectory_in_scene_ * options_.trajectory->pose(options_.trajectory->begin() + (time + 1) / options_.rate);
  }
  // Translation follows the path travelled, rotation the time: a camera that stands still still looks round.
  const double s = time * options_.step, sway = options_.sway;
  double heading = radians(options_.turn * time + sway * 2.5 * wave(time, 71));
  double elevation = radians(sway * 2.0 * wave(time, 53, 0.1));
  double roll = radians(sway * 2.0 * wave(time, 89, 0.3));
  Vector3d position;
  if (options_.scene == "room") {
    const double angle = s / kRoomPathRadius;
    const double radius = kRoomPathRadius + sway * 0.1 * wave(s, 4.1);
    position = {radius * std::cos(angle), radius * std::sin(angle), 1.5 + sway * 0.08 * wave(s, 3.3, 0.1)};
    heading += angle + M_PI / 4;  // between straight ahead and the wall
    elevation -= radians(5);
  } else {
    position = {kStreetStart + s, sway * 0.5 * wave(s, 45), kStreetHeight + sway * 0.02 * wave(s, 7)};
    heading *= 0.6;  // a vehicle rotates less than a hand-held camera
    elevation *= 0.3;
    roll *= 0.3;
  }
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = lookAlong(heading, elevation, roll);
  pose.translation() = position;
  return pose;
}

void Scene::requireFreePath(int frames) const {
  const auto require_free = [&](const Vector3d& from, const Vector3d& to, int frame) {
    const double length = (to - from).norm(), depth = cast(surfaces_, from, to - from).depth;
    if (depth == 0 || (depth - 1) * length > kNear) return;
    std::ostringstream sentence;
    sentence << "the camera leaves the free space of the " << options_.scene << " at frame " << frame << ", "
             << frame / options_.rate << " s after the first; change the offset, or scale or shorten the trajectory";
    throw std::invalid_argument(sentence.str());
  };
  for (int i = 0; i < frames; ++i) {
    require_free(pathAt(i - 1).translation(), pathAt(i).translation(), i);
    require_free(pathAt(i).translation(), poseAt(i).translation(), i);
  }
}

std::vector<ImuSample> Scene::imuSamples(int frames) const {
  if (options_.imu.rate == 0) return {};
  const auto camera_pose = [&](double seconds) { return pathAt(seconds * options_.rate); };
  std::vector<ImuSample> samples =
      simulateImu(camera_pose, -1 / options_.rate, frames / options_.rate, options_.imu, options_.seed);
  for (ImuSample& sample : samples) sample.time += kSceneStart;
  return samples;
}

Scene::View Scene::viewAt(double time) const {
  View view = {poseAt(time), surfaces_};
  const Vector3d middle(0, 0, kMoverHeight / 2);
  Vector3d ahead = view.pose.linear().col(2);
  ahead.z() = 0;
  ahead.normalize();
  const Vector3d right = ahead.cross(Vector3d::UnitZ());
  for (int k = 0; k < options_.movers; ++k) {
    Surface& mover = view.surfaces[view.surfaces.size() - static_cast<size_t>(options_.movers - k)];
    const double aside = (k - 0.5 * (options_.movers - 1)) * kMoverGap + kMoverSway * wave(time, kMoverPeriod, 0.3 * k);
    mover.u = right;
    mover.v = -Vector3d::UnitZ();
    mover.normal = -ahead;
    mover.corner =
        view.pose.translation() + (kMoverDistance + 0.4 * k) * ahead + aside * right - kMoverWidth / 2 * right + middle;
  }
  return view;
}

void Scene::shade(const View& view, const cv::Vec2f& ray, int surface, const cv::Vec3f& hit, uint8_t* out) const {
  float grey;
  Eigen::Vector3f tint(1, 0.96f, 0.93f);
  if (surface < 0) {  // sky, brighter towards the horizon
    const Vector3d d = view.pose.linear() * Vector3d(ray[0], ray[1], 1);
    grey = 235 - 60 * static_cast<float>(std::clamp(d.z() / d.norm(), 0.0, 1.0));
  } else {
    const Surface& s = view.surfaces[surface];
    // Area of the surface that one ray stands for: the Jacobian of the plane's homography is depth^3 / distance.
    const float distance = static_cast<float>(s.normal.dot(view.pose.translation() - s.corner));
    const float depth = 1 / hit[2];
    const float footprint =
        std::sqrt(depth * depth * depth / distance) / static_cast<float>(options_.focal_length * kSamplesPerSide);
    const auto repeated = [&](float length) {
      return options_.repetition > 0 ? std::fmod(length, static_cast<float>(options_.repetition)) : length;
    };
    grey = s.shade * textures_[surface].sample(repeated(hit[0]), repeated(hit[1]), footprint);
    tint = s.tint;
  }
  if (!options_.colour) {
    out[0] = cv::saturate_cast<uint8_t>(grey);
    return;
  }
  for (int k = 0; k < 3; ++k) out[k] = cv::saturate_cast<uint8_t>(grey * tint[k]);
}

void Scene::castGrid(double time, const RayGrid& grid, cv::Mat_<float>* depth, cv::Mat* shading) const {
  View view;
  std::vector<ProjectedSurface> visible;
  const auto look = [&](double at) {
    view = viewAt(at);
    visible.clear();
    for (size_t i = 0; i < view.surfaces.size(); ++i) {
      ProjectedSurface projected;
      projected.index = static_cast<int>(i);
      if (projectSurface(view.surfaces[i], view.pose, projected)) visible.push_back(projected);
    }
  };
  const int rows = grid.rays.rows, columns = grid.rays.cols;
  if (depth) depth->create(rows, columns);
  if (shading) shading->create(rows, columns, options_.colour ? CV_8UC3 : CV_8UC1);
  RowHits hits(columns);
  look(time);
  for (int r = 0; r < rows; ++r) {
    if (options_.readout > 0) look(time + options_.readout * ((r + 0.5) / rows - 0.5));
    const cv::Vec2f* rays = grid.rays[r];
    castRow(visible, rays, columns, grid.y_range[r], hits);
    for (int c = 0; c < columns; ++c) {
      const bool hit = hits.surface[c] >= 0;
      if (depth) (*depth)(r, c) = hit ? 1 / hits.inverse_depth[c] : 0;
      if (shading) {
        shade(view, rays[c], hit ? visible[hits.surface[c]].index : -1, {hits.u[c], hits.v[c], hits.inverse_depth[c]},
              shading->ptr(r) + c * shading->elemSize());
      }
    }
  }
}

cv::Mat Scene::exposed(int index) const {
  cv::Mat samples;
  if (options_.exposure == 0) {
    castGrid(index, samples_, nullptr, &samples);
    return samples;
  }
  cv::Mat sum;
  for (int k = 0; k < kExposures; ++k) {
    castGrid(index + options_.exposure * ((k + 0.5) / kExposures - 0.5), samples_, nullptr, &samples);
    if (sum.empty()) sum = cv::Mat::zeros(samples.size(), CV_MAKETYPE(CV_32F, samples.channels()));
    cv::accumulate(samples, sum);
  }
  sum.convertTo(samples, samples.depth(), 1.0 / kExposures);
  return samples;
}

RenderedFrame Scene::render(int index) const {
  RenderedFrame frame;
  frame.camera_pose = pose(index);
  frame.stamp = stamp(index);
  castGrid(index, centres_, &frame.depth, nullptr);
  cv::resize(exposed(index), frame.image, options_.size, 0, 0, cv::INTER_AREA);
  if (options_.blur > 0) cv::GaussianBlur(frame.image, frame.image, {}, options_.blur);
  if (options_.brightness < 1) frame.image.convertTo(frame.image, -1, options_.brightness);
  const uint64_t camera = options_.offset == 0 ? 0 : uint64_t{1} << 31;  // two cameras have noise of their own
  addNoise(options_.noise, (options_.seed << 32) + camera + index + 1, frame.image);
  return frame;
}

Scene::Hit Scene::cast(const std::vector<Surface>& surfaces, const Vector3d& from, const Vector3d& direction) {
  Hit nearest;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    const Surface& s = surfaces[i];
    const double towards = s.normal.dot(direction), distance = s.normal.dot(s.corner - from);
    if (distance >= 0 || towards >= 0) continue;
    const double depth = distance / towards;
    if (nearest.depth > 0 && depth >= nearest.depth) continue;
    const Vector3d p = from + depth * direction - s.corner;
    const double u = s.u.dot(p), v = s.v.dot(p);
    if (u >= 0 && v >= 0 && u <= s.width && v <= s.height) nearest = {depth, i, u, v};
  }
  return nearest;
}

Scene::Hit Scene::cast(const View& view, const Vector2d& ray) {
  return cast(view.surfaces, view.pose.translation(), view.pose.linear() * ray.homogeneous());
}

double Scene::depth(int index, const cv::Point2d& pixel) const { return cast(viewAt(index), ray(pixel)).depth; }

bool Scene::correspondence(int reference, const cv::Point2d& pixel, int current, cv::Point2d& position) const {
  const View before = viewAt(reference), now = viewAt(current);
  const Hit hit = cast(before, ray(pixel));
  if (hit.depth <= 0) return false;
  const Surface& s = now.surfaces[hit.surface];
  const Vector3d point = now.pose.inverse() * Vector3d(s.corner + hit.u * s.u + hit.v * s.v);
  if (point.z() < kNear) return false;
  position = project(point);
  const cv::Rect2d inside(0, 0, options_.size.width - 1, options_.size.height - 1);
  if (!inside.contains(position)) return false;
  return cast(now, point.head<2>() / point.z()).depth > point.z() * (1 - kOcclusionSlack);
}

}  // namespace gms_ransac
