// Inliers and relative pose -> points in space, in multiples of the baseline.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"

namespace gms_ransac {

/// The inliers of one pair as points, in the order of their rows. Lengths in multiples of |t|.
struct Triangulation {
  std::vector<int> row;                          ///< of the point's match in MatchResult
  std::vector<double> x_reference, y_reference;  ///< undistorted normalised image coordinates
  std::vector<double> x_current, y_current;
  std::vector<double> depth_reference;  ///< along the optical axis; meaningless where not valid
  std::vector<double> depth_current;
  std::vector<double> parallax;  ///< angle between the two rays, radians
  std::vector<uint8_t> valid;    ///< in front of both cameras and enough parallax

  int size() const { return static_cast<int>(row.size()); }
  /// In the current camera's optical frame.
  Eigen::Vector3d point(int i) const { return Eigen::Vector3d(x_current[i], y_current[i], 1) * depth_current[i]; }
};

// Below this the depth of a point is mostly noise: at 500 px focal length it is 1.7 px of displacement.
constexpr double kMinimumParallax = 0.2 * 3.14159265358979323846 / 180;

/// Least-squares depths along the two rays of each inlier (mid-point method; Hartley & Sturm 1997). Empty without a
/// pose or calibration.
void triangulateInliers(const Features& reference, const MatchResult& result, const Camera& camera, Triangulation& out,
                        double minimum_parallax = kMinimumParallax);

/// The same from the columns x, y and the pose alone; fills depths, parallax and valid.
void triangulate(const RelativePose& pose, double minimum_parallax, Triangulation& points);

}  // namespace gms_ransac
