// What small steps of the pose and of the camera's parameters do to the residuals of matches (doc/uncertainty.md).
#pragma once

#include <Eigen/Core>

#include "judgement/lanes.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// What the camera model may get wrong: focal length, principal point (x, y), radial distortion, turns about x, y and z
/// while the rows of the reference and of the current image are read.
struct Unmodelled {
  enum Parameter {
    kFocalLength,
    kPrincipalPoint,
    kRadialDistortion = 3,
    kRowsReference,
    kRowsCurrent = 7,
    kCount = 10
  };
};

/// What a small step of each of the parameters does to a residual through the point (x, y) of the normalised image
/// plane: a focal length, a principal point (x, y), a radial distortion, turns about x, y and z by y radians. (a, b):
/// derivative of the residual by the point; `share`: residual over the squared length of both such derivatives, because
/// a shift that stretches the image stretches its noise. Derived in doc/uncertainty.md.
struct Shifts {
  Lanes effect[7];

  Shifts(const Lanes& a, const Lanes& b, const Lanes& x, const Lanes& y, const Lanes& share) {
    const Lanes aa = a * a, ab = a * b, bb = b * b, both = aa + bb;
    const Lanes xx = x * x, xy = x * y, yy = y * y, along = a * x + b * y, squared = xx + yy;
    effect[0] = share * both - along;
    effect[1] = -a;
    effect[2] = -b;
    effect[3] = squared * along - share * (squared * both + 2 * along * along);
    effect[4] = share * (aa * yy + 2 * ab * xy + bb * (1 + 3 * yy)) - y * (a * xy + b * (1 + yy));
    effect[5] = y * (a * (1 + xx) + b * xy) - share * (2 * both * xy + ab * (1 + squared));
    effect[6] = y * (b * x - a * y) - share * (bb * x - ab * y);
  }
};

/// Derivatives of the signed residual of matches, and that residual.
class ResidualDerivatives {
 public:
  static constexpr int kOfPose = 5;  ///< rotation about x, y and z, two steps of the direction

  explicit ResidualDerivatives(const TwoViewPose& pose)
      : R_(pose.R.cast<float>()), E_(pose.essential().cast<float>()), Et_(E_.transpose()), t_(pose.t.cast<float>()) {
    Eigen::Vector3d basis[2];
    PoseModel::tangent(pose.t, basis);
    for (int i = 0; i < 2; ++i) basis_[i] = VectorLanes(basis[i].cast<float>());
  }

  /// Of the matches from column `i` on: each parameter into a column of its own, `stride` apart. `turns`: likewise how
  /// far each of the two steps of t turns the epipolar line.
  Lanes write(const PointColumnsView& points, int i, float* J, float* turns, int stride) const {
    // doc/residual_kernels.md: value C, squared gradient N, k = C / N; here divided by sqrt(N / w).
    const VectorLanes p(points.x1 + i, points.y1 + i), q(points.x2 + i, points.y2 + i);
    const VectorLanes turned = R_ * p, line2 = E_ * p, line1 = Et_ * q;
    const Lanes N = line2.x * line2.x + line2.y * line2.y + line1.x * line1.x + line1.y * line1.y + kTiny;
    // N is twice the squared distance from the epipole. Padding is beside it, too.
    const auto apart = N * lanes(points.weight + i) > 2 * kBesideEpipole * kBesideEpipole;
    const Lanes none = Lanes::Zero(), unit = apart.select((lanes(points.weight + i) / N).sqrt(), none);
    const Lanes C = dot(q, line2), k = C / N;
    Lanes residual = unit * C;

    // d(rho) = <G, dE> with G = q' p^T - q c^T.
    const VectorLanes q_moved(q.x - k * line2.x, q.y - k * line2.y, q.z);
    const VectorLanes c_moved = k * (R_ * VectorLanes(line1.x, line1.y, Lanes::Zero()));
    // dE = [t]x [w]x R and [step]x R.
    const VectorLanes by_w = cross(turned, cross(q_moved, t_)) - cross(c_moved, cross(q, t_));
    const VectorLanes by_t = cross(turned, q_moved) - cross(c_moved, q);
    const auto put = [&](int parameter, const Lanes& derivative) { lanes(J + parameter * stride) = derivative; };
    put(0, unit * by_w.x);
    put(1, unit * by_w.y);
    put(2, unit * by_w.z);
    for (int step = 0; step < 2; ++step) put(3 + step, unit * dot(basis_[step], by_t));
    // Of a step b the line t x Rp turns by -z Rp . (b x t) / |line|^2, of which N is twice as much where both lines are
    // alike; b x t is the other step but for its sign.
    const Lanes per_length = apart.select(2 * turned.z / N, none);
    lanes(turns) = per_length * dot(basis_[1], turned);
    lanes(turns + stride) = -per_length * dot(basis_[0], turned);

    // Gradients by the two points, whose noise a shift stretches as well.
    const Lanes a1 = unit * (line1.x - k * (E_(0, 0) * line2.x + E_(1, 0) * line2.y));
    const Lanes b1 = unit * (line1.y - k * (E_(0, 1) * line2.x + E_(1, 1) * line2.y));
    const Lanes a2 = unit * (line2.x - k * (E_(0, 0) * line1.x + E_(0, 1) * line1.y));
    const Lanes b2 = unit * (line2.y - k * (E_(1, 0) * line1.x + E_(1, 1) * line1.y));
    const Lanes share = residual / (a1 * a1 + b1 * b1 + a2 * a2 + b2 * b2 + kTiny);
    putShifts(Shifts(a1, b1, p.x, p.y, share), Shifts(a2, b2, q.x, q.y, share), J + kOfPose * stride, stride);
    return residual;
  }

 private:
  /// Thresholds from the epipole, below which noise turns a match's line by so much that nothing of first order holds.
  static constexpr float kBesideEpipole = 3;
  static constexpr float kTiny = 1e-18f;  ///< keeps 0 / 0 out of padding and of matches at both epipoles
  static constexpr int kOfRows = 3;       ///< parameters of a turn by the rows

  /// What the camera gets wrong moves the points of both images alike, but for the turns while their rows are read.
  static void putShifts(const Shifts& reference, const Shifts& current, float* J, int stride) {
    for (int m = 0; m < Unmodelled::kRowsReference; ++m) {
      lanes(J + m * stride) = reference.effect[m] + current.effect[m];
    }
    for (int m = 0; m < kOfRows; ++m) {
      lanes(J + (Unmodelled::kRowsReference + m) * stride) = reference.effect[Unmodelled::kRowsReference + m];
      lanes(J + (Unmodelled::kRowsCurrent + m) * stride) = current.effect[Unmodelled::kRowsReference + m];
    }
  }

  Eigen::Matrix3f R_, E_, Et_;
  VectorLanes t_, basis_[2];
};

}  // namespace gms_ransac
