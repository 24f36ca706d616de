// Centring and scaling of the points of a minimal sample, so that solvers take coordinates in any units.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace gms_ransac {

/// Maps p to scale * (p - centre): zero mean, mean squared distance 2 (Hartley 1997).
struct PointNormalization {
  double centre_x = 0, centre_y = 0, scale = 1;

  template <int N>
  static PointNormalization of(const double (&points)[N][2]) {
    PointNormalization n;
    for (const auto& p : points) {
      n.centre_x += p[0] / N;
      n.centre_y += p[1] / N;
    }
    double squares = 0;
    for (const auto& p : points) {
      squares += (p[0] - n.centre_x) * (p[0] - n.centre_x) + (p[1] - n.centre_y) * (p[1] - n.centre_y);
    }
    if (squares > 0) n.scale = std::sqrt(2.0 * N / squares);
    return n;
  }

  double x(double value) const { return scale * (value - centre_x); }
  double y(double value) const { return scale * (value - centre_y); }
  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d T;
    T << scale, 0, -scale * centre_x, 0, scale, -scale * centre_y, 0, 0, 1;
    return T;
  }
  Eigen::Matrix3d inverse() const {
    Eigen::Matrix3d T;
    T << 1 / scale, 0, centre_x, 0, 1 / scale, centre_y, 0, 0, 1;
    return T;
  }
};

}  // namespace gms_ransac
