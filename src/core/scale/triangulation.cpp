#include "gms_ransac/triangulation.h"

#include <cmath>

namespace gms_ransac {

void triangulate(const RelativePose& pose, double minimum_parallax, Triangulation& points) {
  const size_t n = points.row.size();
  for (auto* column : {&points.depth_reference, &points.depth_current, &points.parallax}) column->resize(n);
  points.valid.resize(n);
  const Eigen::Matrix3d& R = pose.R;
  const double tx = pose.t.x(), ty = pose.t.y(), tz = pose.t.z();
  const double squared_sine = std::pow(std::sin(minimum_parallax), 2);
  for (size_t i = 0; i < n; ++i) {
    // Reference ray a = (x, y, 1), current ray turned into the reference frame b: minimise |l a - t - m b|.
    const double ax = points.x_reference[i], ay = points.y_reference[i];
    const double cx = points.x_current[i], cy = points.y_current[i];
    const double bx = R(0, 0) * cx + R(0, 1) * cy + R(0, 2);
    const double by = R(1, 0) * cx + R(1, 1) * cy + R(1, 2);
    const double bz = R(2, 0) * cx + R(2, 1) * cy + R(2, 2);
    const double aa = ax * ax + ay * ay + 1, bb = bx * bx + by * by + bz * bz, ab = ax * bx + ay * by + bz;
    const double at = ax * tx + ay * ty + tz, bt = bx * tx + by * ty + bz * tz;
    const double determinant = aa * bb - ab * ab;  // squared area between the rays: |a|^2 |b|^2 sin^2
    const double l = (bb * at - ab * bt) / determinant, m = (ab * at - aa * bt) / determinant;
    points.depth_reference[i] = l;
    points.depth_current[i] = m;
    points.parallax[i] = std::atan2(std::sqrt(std::max(determinant, 0.0)), ab);
    points.valid[i] = l > 0 && m > 0 && ab > 0 && determinant >= squared_sine * aa * bb && determinant > 0;
  }
}

void triangulateInliers(const Features& reference, const MatchResult& result, const Camera& camera, Triangulation& out,
                        double minimum_parallax) {
  out.row.clear();
  for (auto* column : {&out.x_reference, &out.y_reference, &out.x_current, &out.y_current}) column->clear();
  if (camera.calibrated() && result.robust.judgement.pose_found) {
    for (size_t row = 0; row < result.matches.size(); ++row) {
      if (!result.isInlier(row)) continue;
      const Match& match = result.matches[row];
      const Eigen::Vector2d r = rayOf(camera, reference.keypoints[static_cast<size_t>(match.reference)].pt);
      const Eigen::Vector2d c = rayOf(camera, result.current_pixel[row]);
      out.row.push_back(static_cast<int>(row));
      out.x_reference.push_back(r.x());
      out.y_reference.push_back(r.y());
      out.x_current.push_back(c.x());
      out.y_current.push_back(c.y());
    }
  }
  triangulate(result.robust.judgement.pose, minimum_parallax, out);
}

}  // namespace gms_ransac
