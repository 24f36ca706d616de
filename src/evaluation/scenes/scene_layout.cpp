#include "scenes/scene_layout.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace gms_ransac {

namespace {

constexpr double kRoomSide = 13, kRoomHeight = 3.6;  // metres

using Eigen::Vector3d;
using Eigen::Vector3f;

const Vector3f kWarm(0.72f, 0.86f, 1.0f), kCool(1.0f, 0.93f, 0.85f), kNeutral(0.95f, 0.97f, 1.0f),
    kWood(0.55f, 0.78f, 1.0f), kRed(0.6f, 0.65f, 1.0f), kGreen(0.75f, 1.0f, 0.78f);

/// Light from above and a little from one side, so that faces that meet differ.
float shadeOf(const Vector3d& normal) {
  const Vector3d light = Vector3d(0.35, 0.55, 0.75).normalized();
  return static_cast<float>(0.78 + 0.22 * normal.dot(light));
}

/// Rectangle seen with `right` pointing right and `down` pointing down.
Surface rectangle(const Vector3d& corner, const Vector3d& right, const Vector3d& down, double width, double height,
                  TextureStyle style, const Vector3f& tint, double texel = 0.005) {
  const Vector3d normal = down.cross(right);
  return {corner, right, down, normal, width, height, shadeOf(normal), style, tint, texel};
}

struct Box {
  Vector3d centre;  ///< of the bottom
  double yaw;       ///< radians
  Vector3d size;    ///< along its own x, y and z
  TextureStyle style;
  Vector3f tint;
};

/// The four sides and the top.
void addBox(const Box& box, std::vector<Surface>& surfaces) {
  const Vector3d x(std::cos(box.yaw), std::sin(box.yaw), 0), y(-x.y(), x.x(), 0), up(0, 0, 1);
  const Vector3d top = box.centre + box.size.z() * up;
  const auto side = [&](const Vector3d& right, const Vector3d& outward, double width, double depth) {
    const Vector3d corner = top + outward * depth / 2 - right * width / 2;
    surfaces.push_back(rectangle(corner, right, -up, width, box.size.z(), box.style, box.tint));
  };
  side(y, x, box.size.y(), box.size.x());
  side(-y, -x, box.size.y(), box.size.x());
  side(-x, y, box.size.x(), box.size.y());
  side(x, -y, box.size.x(), box.size.y());
  const Vector3d corner = top - x * box.size.x() / 2 + y * box.size.y() / 2;
  surfaces.push_back(rectangle(corner, x, -y, box.size.x(), box.size.y(), TextureStyle::kCollage, box.tint));
}

/// Four walls, floor and ceiling round the origin; `size` along x, y and z.
std::vector<Surface> walls(const Vector3d& size, double floor_texel, double ceiling_texel) {
  const Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  const double half_x = size.x() / 2, half_y = size.y() / 2, height = size.z();
  return {
      rectangle({-half_x, half_y, height}, x, -z, size.x(), height, TextureStyle::kPictures, kWarm),
      rectangle({half_x, half_y, height}, -y, -z, size.y(), height, TextureStyle::kBricks, kRed),
      rectangle({half_x, -half_y, height}, -x, -z, size.x(), height, TextureStyle::kPictures, kCool),
      rectangle({-half_x, -half_y, height}, y, -z, size.y(), height, TextureStyle::kStones, kGreen),
      rectangle({-half_x, half_y, 0}, x, -y, size.x(), size.y(), TextureStyle::kPlanks, kWood, floor_texel),
      rectangle({-half_x, -half_y, height}, x, y, size.x(), size.y(), TextureStyle::kPlaster, kNeutral, ceiling_texel)};
}

/// A piece of furniture of random kind and colour.
Box furniture(cv::RNG& rng, const Vector3d& centre, double yaw, const Vector3d& size) {
  const TextureStyle styles[] = {TextureStyle::kShelves, TextureStyle::kCollage, TextureStyle::kCollage,
                                 TextureStyle::kShelves, TextureStyle::kCollage};
  const Vector3f tints[] = {kWood, kWarm, kCool, kGreen, kRed};
  const int style = rng.uniform(0, 5), tint = rng.uniform(0, 5);
  return {centre, yaw, size, styles[style], tints[tint]};
}

/// True if a path keeps the distance from a box, metres.
bool isClear(const std::vector<Vector3d>& path, const Box& box, double distance) {
  const double radius = box.size.head<2>().norm() / 2 + distance, top = box.size.z() + distance;
  return std::none_of(path.begin(), path.end(),
                      [&](const Vector3d& p) { return p.z() < top && (p - box.centre).head<2>().norm() < radius; });
}

}  // namespace

std::vector<Surface> roomSurfaces(uint64_t seed) {
  constexpr double kHalf = kRoomSide / 2;
  std::vector<Surface> surfaces = walls({kRoomSide, kRoomSide, kRoomHeight}, 0.008, 0.01);
  cv::RNG rng(seed + 1);
  const auto add = [&](double px, double py, double yaw, double w, double d, double h) {
    addBox(furniture(rng, {px, py, 0}, yaw, {w, d, h}), surfaces);
  };
  for (int wall = 0; wall < 4; ++wall) {  // cupboards along the walls, their backs against them
    const double yaw = wall * M_PI / 2;
    const Vector3d out(std::cos(yaw), std::sin(yaw), 0), along(-out.y(), out.x(), 0);
    for (double s : {-4.6, -1.4, 2.2, 4.8}) {
      const double depth = rng.uniform(0.35, 0.8), width = rng.uniform(0.9, 1.7), height = rng.uniform(0.6, 2.2);
      const Vector3d p = out * (kHalf - depth / 2 - 0.02) + along * (s + rng.uniform(-0.4, 0.4));
      add(p.x(), p.y(), yaw, depth, width, height);
    }
    const Vector3d crate = out * 4.7 + along * 4.3;  // crates standing free in the corners
    add(crate.x(), crate.y(), yaw + rng.uniform(0.2, 1.2), 0.7, 0.6, rng.uniform(0.5, 1.3));
  }
  for (int i = 0; i < 20; ++i) {  // free-standing columns and crates next to the path
    const double angle = (i + rng.uniform(-0.25, 0.25)) * M_PI / 10, r = rng.uniform(4.7, 5.3);
    const double turn = rng.uniform(0.0, 1.5), width = rng.uniform(0.25, 0.55), height = rng.uniform(1.1, 2.4);
    add(r * std::cos(angle), r * std::sin(angle), turn, width, 0.8 * width, height);
  }
  for (int i = 0; i < 6; ++i) {  // pillars and tables in the middle, inside the path
    const double angle = i * M_PI / 3 + rng.uniform(-0.2, 0.2), r = rng.uniform(0.9, 2.0);
    add(r * std::cos(angle), r * std::sin(angle), rng.uniform(0.0, 1.5), rng.uniform(0.3, 0.8), rng.uniform(0.3, 0.8),
        rng.uniform(0.6, 2.6));
  }
  return surfaces;
}

std::vector<Surface> hallSurfaces(uint64_t seed, const std::vector<Vector3d>& path) {
  constexpr double kToWall = 3, kToCeiling = 1.5, kClear = 0.7, kPitch = 2, kMostInARow = 20;
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : path) box.extend(p);
  if (box.sizes().head<2>().maxCoeff() > kLargestPath) {
    throw std::invalid_argument(
        cv::format("the trajectory is %.0f m x %.0f m in size, a room %.0f m; scale or shorten it", box.sizes().x(),
                   box.sizes().y(), kLargestPath));
  }
  const Vector3d size(std::max(kRoomSide, box.sizes().x() + 2 * kToWall),
                      std::max(kRoomSide, box.sizes().y() + 2 * kToWall),
                      std::max(kRoomHeight, box.max().z() + kToCeiling));
  // Furniture and texels grow with the hall, so that their number does not.
  const double pitch = std::max(kPitch, size.head<2>().maxCoeff() / kMostInARow), growth = pitch / kPitch;
  std::vector<Surface> surfaces = walls(size, 0.004 * growth, 0.005 * growth);
  cv::RNG rng(seed + 3);
  for (double x = -size.x() / 2 + pitch / 2; x < size.x() / 2 - pitch / 3; x += pitch) {
    for (double y = -size.y() / 2 + pitch / 2; y < size.y() / 2 - pitch / 3; y += pitch) {
      const double aside = pitch * rng.uniform(-0.2, 0.2), ahead = pitch * rng.uniform(-0.2, 0.2);
      const double yaw = rng.uniform(0.0, 1.5), width = growth * rng.uniform(0.3, 0.8);
      const double depth = growth * rng.uniform(0.3, 0.8), height = size.z() * rng.uniform(0.15, 0.75);
      const Box piece = furniture(rng, {x + aside, y + ahead, 0}, yaw, {width, depth, height});
      if (isClear(path, piece, kClear)) addBox(piece, surfaces);
    }
  }
  return surfaces;
}

std::vector<Surface> streetSurfaces(uint64_t seed) {
  constexpr double kHalfWidth = 5.5, kTexel = 0.02;
  const Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  std::vector<Surface> surfaces = {rectangle({0, kHalfWidth + 4, 0}, x, -y, kStreetLength, 2 * kHalfWidth + 8,
                                             TextureStyle::kStones, kNeutral, kTexel)};
  cv::RNG rng(seed + 2);
  const TextureStyle fronts[] = {TextureStyle::kFacade, TextureStyle::kBricks, TextureStyle::kFacade};
  const Vector3f tints[] = {kWarm, kCool, kRed, kWood, kNeutral, kGreen};
  for (double side : {-1.0, 1.0}) {
    // Houses of different depth and height next to each other; cross walls show where one stands out.
    for (double s = 0; s < kStreetLength;) {
      const double length = std::min(rng.uniform(6.0, 14.0), kStreetLength - s), height = rng.uniform(4.5, 9.0);
      const double front = side * (kHalfWidth + rng.uniform(0.0, 1.0)), back = front + side * 3;
      const TextureStyle style = fronts[rng.uniform(0, 3)];
      const Vector3f& tint = tints[rng.uniform(0, 6)];
      const double left = side > 0 ? s : s + length;
      surfaces.push_back(rectangle({left, front, height}, side * x, -z, length, height, style, tint, kTexel));
      surfaces.push_back(rectangle({s, side > 0 ? back : front, height}, -y, -z, 3, height, style, tint, kTexel));
      surfaces.push_back(
          rectangle({s + length, side > 0 ? front : back, height}, y, -z, 3, height, style, tint, kTexel));
      s += length;
    }
    // Vehicles, kiosks and poles at the kerb.
    for (double s = rng.uniform(2.0, 5.0); s < kStreetLength - 3; s += rng.uniform(4.0, 9.0)) {
      const bool pole = rng.uniform(0.0, 1.0) < 0.35;
      const Vector3d size = pole ? Vector3d(0.22, 0.22, rng.uniform(2.5, 4.5))
                                 : Vector3d(rng.uniform(1.6, 4.2), rng.uniform(1.2, 1.7), rng.uniform(1.1, 2.2));
      addBox({{s, side * rng.uniform(3.2, 4.2), 0},
              rng.uniform(-0.12, 0.12),
              size,
              TextureStyle::kCollage,
              tints[rng.uniform(0, 6)]},
             surfaces);
    }
  }
  surfaces.push_back(rectangle({kStreetLength, kHalfWidth + 1, 8}, -y, -z, 2 * kHalfWidth + 2, 8, TextureStyle::kFacade,
                               kCool, kTexel));
  return surfaces;
}

}  // namespace gms_ransac
