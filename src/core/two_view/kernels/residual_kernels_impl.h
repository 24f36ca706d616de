// The kernels, written once over a register of floats. Included by one file for each instruction set, which defines
// GMS_RANSAC_VECTOR_BYTES, those of its registers, before; everything lies in an unnamed namespace so that no two sets
// share a function.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "two_view/kernels/residual_kernels.h"

namespace gms_ransac {
namespace {

/// One register of floats in the compiler's own vector types.
using V [[gnu::vector_size(GMS_RANSAC_VECTOR_BYTES)]] = float;
constexpr int kWidth = GMS_RANSAC_VECTOR_BYTES / sizeof(float), kParts = kLanes / kWidth;

inline V load(const float* p) {
  V a;
  std::memcpy(&a, p, sizeof a);
  return a;
}
inline void store(const V& a, float* p) { std::memcpy(p, &a, sizeof a); }
inline V set(float a) { return a - V{}; }
/// a < b ? x : y
inline V select(const V& a, const V& b, const V& x, const V& y) { return a < b ? x : y; }
inline V minimum(const V& a, const V& b) { return select(a, b, a, b); }
inline V maximum(const V& a, const V& b) { return select(b, a, a, b); }
inline V squareRoot(const V& a) {
  float lanes[kWidth];
  store(a, lanes);
  for (float& x : lanes) x = std::sqrt(x);
  return load(lanes);
}

using Bits [[gnu::vector_size(GMS_RANSAC_VECTOR_BYTES)]] = int32_t;

/// exp(x), and no less than the smallest number or more than the largest: a power of two times a Taylor series.
inline V exponential(const V& x) {
  const V power = maximum(minimum(x * set(1.44269504f), set(126)), set(-125));
  const V rounded = power + set(0x1.8p23f);  // whose lowest bits are the integer
  const V rest = (power - (rounded - set(0x1.8p23f))) * set(0.693147181f);
  V series = set(1 / 720.f);
  for (const float coefficient : {1 / 120.f, 1 / 24.f, 1 / 6.f, 0.5f, 1.f, 1.f}) {
    series = series * rest + set(coefficient);
  }
  return V(Bits(series) + (Bits(rounded) << 23));
}

/// Natural logarithm of a positive number: of its power of two, and of the rest, which is about 1.
inline V logarithm(const V& x) {
  const Bits power = (Bits(x) - 0x3f3504f3) >> 23;  // from the root of 1/2 on
  const V rest = V(Bits(x) - (power << 23));
  const V s = (rest - set(1)) / (rest + set(1)), square = s * s;
  V series = set(1 / 7.f);
  for (const float coefficient : {1 / 5.f, 1 / 3.f, 1.f}) series = series * square + set(coefficient);
  return __builtin_convertvector(power, V) * set(0.693147181f) + set(2) * s * series;
}

/// The error function of a number that is not negative, to 2e-7 (Abramowitz & Stegun 7.1.26).
inline V errorFunction(const V& x) {
  const V t = set(1) / (set(1) + set(0.3275911f) * x);
  V series = set(1.061405429f);
  for (const float coefficient : {-1.453152027f, 1.421413741f, -0.284496736f, 0.254829592f}) {
    series = series * t + set(coefficient);
  }
  return set(1) - series * t * exponential(set(0) - x * x);
}

/// Adds one half to the other until one number remains.
template <int kCount, typename Floats>
float sumOf(const Floats& floats) {
  if constexpr (kCount == 4) {
    return (floats[0] + floats[2]) + (floats[1] + floats[3]);
  } else {
    using Half [[gnu::vector_size(kCount / 2 * sizeof(float))]] = float;
    Half halves[2];
    std::memcpy(halves, &floats, sizeof halves);
    return sumOf<kCount / 2>(Half(halves[0] + halves[1]));
  }
}

/// Sums over kLanes matches at a time: a part for each register of them, because the terms of all would not fit into
/// the registers. Starts at zero.
template <class Part>
struct Parts {
  Part part[kParts] = {};

  /// add(i, part) for the matches from i on.
  template <class Add>
  void forEach(int first, int end, const Add& add) {
    for (int i = first; i < end; i += kWidth) add(i, part[i / kWidth % kParts]);
  }
  /// of(part): a register of one of the sums.
  template <class Of>
  float total(const Of& of) const {
    V all = of(part[0]);
    if constexpr (kParts == 2) all = of(part[0]) + of(part[1]);
    if constexpr (kParts == 4) all = (of(part[0]) + of(part[2])) + (of(part[1]) + of(part[3]));
    return sumOf<kWidth>(all);
  }
};

struct Kernels {
  static constexpr int kBlock = 4 * kLanes;  // matches between two looks at the bound
  // Keeps 0 / 0 out of padding and of matches at both epipoles.
  static constexpr float kTiny = 1e-18f;

  struct Point {
    V x1, y1, x2, y2, w;
    Point(const PointColumnsView& p, int i)
        : x1(load(p.x1 + i)), y1(load(p.y1 + i)), x2(load(p.x2 + i)), y2(load(p.y2 + i)), w(load(p.weight + i)) {}
  };

  struct Matrix {
    V m[9];
    explicit Matrix(const float (&a)[9]) {
      for (int i = 0; i < 9; ++i) m[i] = set(a[i]);
    }
    V row(int r, V x, V y) const { return m[3 * r] * x + m[3 * r + 1] * y + m[3 * r + 2]; }
    V column(int c, V x, V y) const { return m[c] * x + m[3 + c] * y + m[6 + c]; }
  };

  struct Epipolar {
    V a, b, c;      // line in the current image
    V d, f;         // first two of the line in the reference image
    V value, norm;  // x2^T M x1 and the squared gradient
    Epipolar(const Matrix& M, const Point& p)
        : a(M.row(0, p.x1, p.y1)),
          b(M.row(1, p.x1, p.y1)),
          c(M.row(2, p.x1, p.y1)),
          d(M.column(0, p.x2, p.y2)),
          f(M.column(1, p.x2, p.y2)),
          value(a * p.x2 + b * p.y2 + c),
          norm((a * a + b * b) + (d * d + f * f) + set(kTiny)) {}
    V residual(V w) const { return w * value * value / norm; }
    V residual(V w, V inverse_norm) const { return w * value * value * inverse_norm; }
  };

  /// The displacement of a match that the rotation of a pose does not explain.
  struct Parallax {
    V u, v, z;  // the reference point rotated
    V m0, m1;   // (y2 - v / z, u / z - x2) * z
    V inverse_z;
    V inverse_norm;  // of the Epipolar: divisions are dear, and one serves both
    V squared;       // squared displacement over the squared threshold
    Parallax(const Matrix& R, const Point& p, const Epipolar& s)
        : u(R.row(0, p.x1, p.y1)),
          v(R.row(1, p.x1, p.y1)),
          z(R.row(2, p.x1, p.y1)),
          m0(p.y2 * z - v),
          m1(u - p.x2 * z) {
      const V squared_z = z * z + set(kTiny), inverse = set(1) / (s.norm * squared_z);
      inverse_norm = squared_z * inverse;
      inverse_z = z * (s.norm * inverse);
      squared = p.w * (m0 * m0 + m1 * m1) * (inverse_z * inverse_z);
    }
  };

  /// The current point's ray times the translation.
  struct RayTimesTranslation {
    V n0, n1, n2;
    RayTimesTranslation(const V (&t)[3], const Point& p)
        : n0(p.y2 * t[2] - t[1]), n1(t[0] - p.x2 * t[2]), n2(p.x2 * t[1] - p.y2 * t[0]) {}
  };

  /// e of a match behind a camera, or whose rays meet at more than a right angle, and 0 for any other.
  static V behindResidual(const Parallax& d, const RayTimesTranslation& n, const Epipolar& s, const Point& p) {
    const V m2 = p.x2 * d.v - p.y2 * d.u;
    // Signs of minus the depth in the reference and of the depth in the current image.
    const V depth1 = d.m0 * n.n0 + d.m1 * n.n1 + m2 * n.n2, depth2 = s.a * d.m0 + s.b * d.m1 + s.c * m2;
    const V zero = set(0), at_infinity = set(0.5f) * d.squared;
    const V in_front = select(zero, d.u * p.x2 + d.v * p.y2 + d.z, zero, at_infinity);
    return select(depth1, zero, select(zero, depth2, in_front, at_infinity), at_infinity);
  }

  struct Pose {
    Matrix E, R;
    V t[3];
    explicit Pose(const PoseParameters& p) : E(p.E), R(p.R), t{set(p.t[0]), set(p.t[1]), set(p.t[2])} {}
  };

  /// A match under a pose.
  struct Seen {
    Point p;
    Epipolar s;
    Parallax d;
    RayTimesTranslation n;
    Seen(const Pose& pose, const PointColumnsView& points, int i)
        : p(points, i), s(pose.E, p), d(pose.R, p, s), n(pose.t, p) {}
    /// The Sampson distance, and no less than at infinity for a match behind a camera.
    V residual() const { return maximum(s.residual(p.w, d.inverse_norm), behindResidual(d, n, s, p)); }
  };

  struct Prior {
    V weight, inverse_scale, quarter;
    explicit Prior(const ParallaxPrior& prior)
        : weight(set(prior.weight)),
          inverse_scale(set(prior.inverse_scale)),
          quarter(set(0.25f * prior.weight * prior.inverse_scale)) {}
    V cost(const Parallax& d) const {
      const V root = squareRoot(set(1) + d.squared * inverse_scale);
      return weight * (squareRoot(root) - set(1));
    }
    /// The cost, its derivative with respect to the squared displacement, and the inverse of `divisor` by the same
    /// division.
    V cost(const Parallax& d, V divisor, V& slope, V& inverse) const {
      const V root = squareRoot(set(1) + d.squared * inverse_scale);
      const V fourth_root = squareRoot(root);
      const V cubed = root * fourth_root, both = set(1) / (cubed * divisor);
      slope = quarter * (both * divisor);
      inverse = both * cubed;
      return weight * (fourth_root - set(1));
    }
  };

  struct Sum {
    V cost, inliers;
    void add(V e) { add(e, set(0)); }
    void add(V e, V prior) {
      const V one = set(1);
      cost += minimum(e + prior, one);
      inliers += select(e, one, one, set(0));
    }
  };

  /// add(i, sum) adds the matches from i on.
  template <class Add>
  static void scoreAll(const PointColumnsView& points, float bound, HypothesisScore& score, const Add& add) {
    Parts<Sum> sums;
    int looked_at = 0;
    do {
      const int end = looked_at + kBlock < points.size ? looked_at + kBlock : points.size;
      sums.forEach(looked_at, end, add);
      looked_at = end;
      score.cost = sums.total([](const Sum& sum) { return sum.cost; });
    } while (looked_at < points.size && !(score.cost > bound));
    score.evaluated = looked_at < points.count ? looked_at : points.count;
    const float inliers = sums.total([](const Sum& sum) { return sum.inliers; });
    score.inliers = static_cast<int>(inliers) - (looked_at - score.evaluated);  // padding counts as inliers
  }

  static void scoreEpipolar(const PointColumnsView& points, const float (&M)[9], float bound, HypothesisScore& score) {
    const Matrix m(M);
    scoreAll(points, bound, score, [&](int i, Sum& sum) {
      const Point p(points, i);
      sum.add(Epipolar(m, p).residual(p.w));
    });
  }

  static void scorePose(const PointColumnsView& points, const PoseParameters& parameters,
                        const ParallaxPrior& parallax_prior, float bound, HypothesisScore& score) {
    const Pose pose(parameters);
    const Prior prior(parallax_prior);
    scoreAll(points, bound, score, [&](int i, Sum& sum) {
      const Seen seen(pose, points, i);
      sum.add(seen.residual(), prior.cost(seen.d));
    });
  }

  static V transferSquared(const Matrix& H, V x1, V y1, V x2, V y2) {
    const V z = H.row(2, x1, y1);
    const V dx = H.row(0, x1, y1) - x2 * z, dy = H.row(1, x1, y1) - y2 * z;
    return (dx * dx + dy * dy) / (z * z + set(kTiny));
  }

  static void scoreHomography(const PointColumnsView& points, const float (&H)[9], const float (&G)[9], float bound,
                              HypothesisScore& score) {
    const Matrix h(H), g(G);
    scoreAll(points, bound, score, [&](int i, Sum& sum) {
      const Point p(points, i);
      sum.add(set(0.5f) * p.w *
              (transferSquared(h, p.x1, p.y1, p.x2, p.y2) + transferSquared(g, p.x2, p.y2, p.x1, p.y1)));
    });
  }

  static void epipolarResiduals(const PointColumnsView& points, const float (&M)[9], float* e) {
    const Matrix m(M);
    for (int i = 0; i < points.size; i += kWidth) {
      const Point p(points, i);
      store(Epipolar(m, p).residual(p.w), e + i);
    }
  }

  static void poseResiduals(const PointColumnsView& points, const PoseParameters& parameters, float* e) {
    const Pose pose(parameters);
    for (int i = 0; i < points.size; i += kWidth) store(Seen(pose, points, i).residual(), e + i);
  }

  static void transferResiduals(const PointColumnsView& points, const float (&H)[9], float* e) {
    const Matrix h(H);
    for (int i = 0; i < points.size; i += kWidth) {
      const Point p(points, i);
      store(p.w * transferSquared(h, p.x1, p.y1, p.x2, p.y2), e + i);
    }
  }

  template <int P>
  struct Equations {
    V matrix[P * (P + 1) / 2], gradient[P], cost, weight;
    void add(const V (&J)[P], V residual, V w) {
      int k = 0;
#pragma GCC unroll 8
      for (int i = 0; i < P; ++i) {
        const V s = w * J[i];
        gradient[i] += s * residual;
#pragma GCC unroll 8
        for (int j = i; j < P; ++j) matrix[k++] += s * J[j];
      }
    }
  };

  template <int P>
  static void finish(const Parts<Equations<P>>& sums, const PointColumnsView& points, NormalEquations<P>& equations) {
    for (int k = 0; k < P * (P + 1) / 2; ++k) {
      equations.matrix[k] = sums.total([k](const auto& part) { return part.matrix[k]; });
    }
    for (int i = 0; i < P; ++i) equations.gradient[i] = sums.total([i](const auto& part) { return part.gradient[i]; });
    equations.cost = sums.total([](const auto& part) { return part.cost; });
    equations.weight =
        sums.total([](const auto& part) { return part.weight; }) - static_cast<float>(points.size - points.count);
  }

  static V lossDivisor(const Loss& loss, V e) {
    return set(1) + minimum(e, set(loss.cut)) * set(loss.inverse_softness);
  }

  /// Weight of the loss at e, and its cost added to `equations`.
  template <int P>
  static V lossWeight(const Loss& loss, V e, Equations<P>& equations) {
    return lossWeight(loss, e, set(1) / lossDivisor(loss, e), equations);
  }

  template <int P>
  static V lossWeight(const Loss& loss, V e, V q, Equations<P>& equations) {
    const V cut = set(loss.cut);
    equations.cost += minimum(e, cut) * q;
    const V weight = select(e, cut, q * q, set(0));
    equations.weight += weight;
    return weight;
  }

  /// Derivative of the Sampson distance times its own norm, by the chain rule through the nine entries of the matrix:
  /// d(value / sqrt(norm)) sqrt(norm) = x2 x1^T - value / norm (line2 x1^T + x2 line1^T).
  template <int P>
  static void addEpipolar(const Epipolar& s, const Point& p, const V (&D)[P][9], V weight, Equations<P>& equations) {
    const V k = s.value / s.norm;
    const V r0 = p.x2 - k * s.a, r1 = p.y2 - k * s.b;
    const V c0 = k * s.d, c1 = k * s.f;
    const V g[9] = {r0 * p.x1 - c0 * p.x2,
                    r0 * p.y1 - c1 * p.x2,
                    r0,
                    r1 * p.x1 - c0 * p.y2,
                    r1 * p.y1 - c1 * p.y2,
                    r1,
                    p.x1 - c0,
                    p.y1 - c1,
                    set(1)};
    V J[P];
    for (int i = 0; i < P; ++i) {
      V sum = D[i][0] * g[0];
      for (int j = 1; j < 9; ++j) sum = sum + D[i][j] * g[j];
      J[i] = sum;
    }
    equations.add(J, s.value, weight * p.w / s.norm);
  }

  template <int P>
  static void broadcast(const float (&D)[P][9], V (&d)[P][9]) {
    for (int i = 0; i < P; ++i) {
      for (int j = 0; j < 9; ++j) d[i][j] = set(D[i][j]);
    }
  }

  /// Derivatives of a point by a rotation of its ray.
  static void rotationDerivatives(V a, V b, V (&Jx)[3], V (&Jy)[3]) {
    const V one = set(1), zero = set(0), ab = a * b;
    Jx[0] = zero - ab, Jx[1] = one + a * a, Jx[2] = zero - b;
    Jy[0] = zero - (one + b * b), Jy[1] = ab, Jy[2] = a;
  }

  /// The prior's share of the normal equations: the displacement depends on the rotation alone.
  static void addPrior(const Parallax& d, V slope, V inlier, const Point& p, Equations<5>& equations) {
    const V a = d.u * d.inverse_z, b = d.v * d.inverse_z;
    const V dx = a - p.x2, dy = b - p.y2;
    V Jx[3], Jy[3];
    rotationDerivatives(a, b, Jx, Jy);
    const V weight = inlier * p.w * slope;
    int k = 0;
    for (int i = 0; i < 3; ++i) {
      const V sx = weight * Jx[i], sy = weight * Jy[i];
      equations.gradient[i] += sx * dx + sy * dy;
      for (int j = i; j < 3; ++j) equations.matrix[k + j - i] += sx * Jx[j] + sy * Jy[j];
      k += 5 - i;
    }
  }

  /// As in addEpipolar, for the entries of E = [t]x R. With x = q - k (a, b, 0) for the current ray q, r = R p for the
  /// reference ray p and s = R (d, f, 0), the derivative along dE is x . dE p - k q . dE (d, f, 0), where dE p is
  /// t x (w x r) for a rotation w and (step) x r for a step of t.
  static void poseDerivatives(const Seen& seen, const Pose& pose, const V (&basis)[2][3], V (&J)[5]) {
    const auto& [p, s, d, n] = seen;
    const auto& [E, R, t] = pose;
    const V k = s.value * d.inverse_norm;
    const V ka = k * s.a, kb = k * s.b, kd = k * s.d, kf = k * s.f;
    const V x0 = p.x2 - ka, x1 = p.y2 - kb;
    const V s0 = R.m[0] * kd + R.m[1] * kf, s1 = R.m[3] * kd + R.m[4] * kf, s2 = R.m[6] * kd + R.m[7] * kf;
    const V w0 = n.n0 - kb * t[2], w1 = n.n1 + ka * t[2], w2 = n.n2 - (ka * t[1] - kb * t[0]);
    const V m0 = (d.v - d.z * x1) - (s1 - s2 * p.y2), m1 = (d.z * x0 - d.u) - (s2 * p.x2 - s0);
    const V m2 = (d.u * x1 - d.v * x0) - (s0 * p.y2 - s1 * p.x2);
    J[0] = (d.v * w2 - d.z * w1) - (s1 * n.n2 - s2 * n.n1);
    J[1] = (d.z * w0 - d.u * w2) - (s2 * n.n0 - s0 * n.n2);
    J[2] = (d.u * w1 - d.v * w0) - (s0 * n.n1 - s1 * n.n0);
    J[3] = basis[0][0] * m0 + basis[0][1] * m1 + basis[0][2] * m2;
    J[4] = basis[1][0] * m0 + basis[1][1] * m1 + basis[1][2] * m2;
  }

  /// A float for each coordinate and step.
  static void broadcast(const float (&basis)[2][3], V (&steps)[2][3]) {
    for (int i = 0; i < 6; ++i) steps[i / 3][i % 3] = set(basis[i / 3][i % 3]);
  }

  /// Derivatives of a residual by the parameters of the camera model, through the point (x, y) of one image. (a, b):
  /// derivative of the residual by the point; `share`: residual over the squared length of both such derivatives,
  /// because a shift that stretches the image stretches its noise.
  struct Shifts {
    V effect[7];
    Shifts(V a, V b, V x, V y, V share) {
      const V one = set(1), two = set(2), three = set(3), zero = set(0);
      const V aa = a * a, ab = a * b, bb = b * b, both = aa + bb;
      const V xx = x * x, xy = x * y, yy = y * y, along = a * x + b * y, squared = xx + yy;
      effect[0] = share * both - along;
      effect[1] = zero - a;
      effect[2] = zero - b;
      effect[3] = squared * along - share * (squared * both + two * along * along);
      effect[4] = share * (aa * yy + two * ab * xy + bb * (one + three * yy)) - y * (a * xy + b * (one + yy));
      effect[5] = y * (a * (one + xx) + b * xy) - share * (two * both * xy + ab * (one + squared));
      effect[6] = y * (b * x - a * y) - share * (bb * x - ab * y);
    }
  };

  static DerivativeSums differentiatePose(const PointColumnsView& points, const PoseParameters& parameters,
                                          const float (&basis)[2][3], const Loss& loss, float* columns) {
    // Closer to the epipole, in thresholds, noise rotates the line of a match: nothing of first order holds.
    constexpr float kNearEpipole = 3;
    using Column = DerivativeColumn;
    const Pose pose(parameters);
    const Matrix& E = pose.E;
    const V zero = set(0), one = set(1), softness = set(loss.inverse_softness), cut = set(loss.cut);
    const V near_epipole = set(2 * kNearEpipole * kNearEpipole);  // the norm is twice the squared distance
    V steps[2][3];
    broadcast(basis, steps);
    struct Sum {
      V curvature, used;
    };
    Parts<Sum> parts;
    parts.forEach(0, points.size, [&](int i, Sum& sum) {
      const Seen seen(pose, points, i);
      const auto& [p, s, d, n] = seen;
      const V counts = select(near_epipole, s.norm * p.w, select(s.residual(p.w), cut, one, zero), zero);
      const V k = s.value / s.norm, unit = counts * squareRoot(p.w / s.norm), residual = unit * s.value;
      V by_pose[Column::kPoseCount], J[Column::kCount];
      poseDerivatives(seen, pose, steps, by_pose);
      for (int m = 0; m < Column::kPoseCount; ++m) J[m] = unit * by_pose[m];
      // A step b rotates the line t x Rp by -z Rp . (b x t) / |line|^2. The norm is twice |line|^2 if both lines are
      // alike; b x t is the other step except for its sign.
      const V per_length = counts * set(2) * d.z / s.norm;
      J[Column::kLineRotation] = per_length * (steps[1][0] * d.u + steps[1][1] * d.v + steps[1][2] * d.z);
      J[Column::kLineRotation + 1] = zero - per_length * (steps[0][0] * d.u + steps[0][1] * d.v + steps[0][2] * d.z);
      // Derivatives by the two points, whose noise a shift stretches as well.
      const V a1 = unit * (s.d - k * (E.m[0] * s.a + E.m[3] * s.b)),
              b1 = unit * (s.f - k * (E.m[1] * s.a + E.m[4] * s.b));
      const V a2 = unit * (s.a - k * (E.m[0] * s.d + E.m[1] * s.f)),
              b2 = unit * (s.b - k * (E.m[3] * s.d + E.m[4] * s.f));
      const V share = residual / ((a1 * a1 + b1 * b1) + (a2 * a2 + b2 * b2) + set(kTiny));
      const Shifts reference(a1, b1, p.x1, p.y1, share), current(a2, b2, p.x2, p.y2, share);
      for (int m = 0; m < 4; ++m) J[Column::kFocalLength + m] = reference.effect[m] + current.effect[m];
      for (int m = 0; m < 3; ++m) {
        J[Column::kRowsReference + m] = reference.effect[4 + m];
        J[Column::kRowsCurrent + m] = current.effect[4 + m];
      }
      const V softened = residual * residual * softness, falloff = one / (one + softened), weight = falloff * falloff;
      J[Column::kPull] = weight * residual;
      sum.curvature += counts * (weight * falloff * (one - set(3) * softened));
      sum.used += counts;
      for (int m = 0; m < Column::kCount; ++m) store(J[m], columns + m * points.size + i);
    });
    DerivativeSums sums;
    sums.curvature = parts.total([](const Sum& sum) { return sum.curvature; });
    sums.used = static_cast<int>(parts.total([](const Sum& sum) { return sum.used; }));
    return sums;
  }

  static void sumProducts(const float* columns, int size, double* sums) {
    // By blocks of slots, which single precision sums well enough, and tiles of columns: what is loaded is used thrice.
    constexpr int kRows = 16 * kLanes, kTile = 3, kColumns = DerivativeColumn::kParameterCount;
    static_assert(kColumns % kTile == 0, "whole tiles");
    for (int k = 0; k < kColumns * (kColumns + 1) / 2; ++k) sums[k] = 0;
    for (int first = 0; first < size; first += kRows) {
      const int end = first + kRows < size ? first + kRows : size;
      for (int k = 0; k < kColumns; k += kTile) {
        for (int l = 0; l <= k; l += kTile) {
          struct Tile {
            V entry[kTile][kTile];
          };
          Parts<Tile> tiles;
          for (int part = 0; part < kParts; ++part) {
            auto& [entry] = tiles.part[part];
            for (int i = first + part * kWidth; i < end; i += kLanes) {
              const float *left = columns + k * size + i, *right = columns + l * size + i;
              const V a[kTile] = {load(left), load(left + size), load(left + 2 * size)};
              for (int column = 0; column < kTile; ++column) {
                const V b = load(right + column * size);
                for (int row = 0; row < kTile; ++row) entry[row][column] += a[row] * b;
              }
            }
          }
          for (int row = k; row < k + kTile; ++row) {
            for (int column = l; column < l + kTile && column <= row; ++column) {
              const auto of = [&](const Tile& tile) { return tile.entry[row - k][column - l]; };
              sums[row * (row + 1) / 2 + column] += static_cast<double>(tiles.total(of));
            }
          }
        }
      }
    }
  }

  static void linearizePose(const PointColumnsView& points, const PoseParameters& parameters,
                            const float (&basis)[2][3], const Loss& loss, const ParallaxPrior& parallax_prior,
                            NormalEquations<5>& equations) {
    const Pose pose(parameters);
    V steps[2][3];
    broadcast(basis, steps);
    const Prior prior(parallax_prior);
    Parts<Equations<5>> sums;
    sums.forEach(0, points.size, [&](int i, Equations<5>& part) {
      const Seen seen(pose, points, i);
      const V e = seen.residual();
      V q, slope, J[5];
      if (parallax_prior.weight > 0) {
        const V counts = select(e, set(loss.cut), set(1), set(0));
        part.cost += counts * prior.cost(seen.d, lossDivisor(loss, e), slope, q);
        addPrior(seen.d, slope, counts, seen.p, part);
      } else {
        q = set(1) / lossDivisor(loss, e);
      }
      poseDerivatives(seen, pose, steps, J);
      part.add(J, seen.s.value, lossWeight(loss, e, q, part) * seen.p.w * seen.d.inverse_norm);
    });
    finish(sums, points, equations);
  }

  static float poseCost(const PointColumnsView& points, const PoseParameters& parameters, const Loss& loss,
                        const ParallaxPrior& parallax_prior) {
    const Pose pose(parameters);
    const Prior prior(parallax_prior);
    const V cut = set(loss.cut);
    Parts<V> sums;
    sums.forEach(0, points.size, [&](int i, V& cost) {
      const Seen seen(pose, points, i);
      const V e = seen.residual();
      V q, slope;
      if (parallax_prior.weight > 0) {
        const V counts = select(e, cut, set(1), set(0));
        cost += counts * prior.cost(seen.d, lossDivisor(loss, e), slope, q);
      } else {
        q = set(1) / lossDivisor(loss, e);
      }
      cost += minimum(e, cut) * q;
    });
    return sums.total([](const V& cost) { return cost; });
  }

  static void linearizeFundamental(const PointColumnsView& points, const float (&F)[9], const float (&D)[7][9],
                                   const Loss& loss, NormalEquations<7>& equations) {
    const Matrix M(F);
    V d[7][9];
    broadcast(D, d);
    Parts<Equations<7>> sums;
    sums.forEach(0, points.size, [&](int i, Equations<7>& part) {
      const Point p(points, i);
      const Epipolar s(M, p);
      addEpipolar(s, p, d, lossWeight(loss, s.residual(p.w), part), part);
    });
    finish(sums, points, equations);
  }

  /// The image of a point, and its difference from the match.
  struct Transfer {
    V inverse_z, u, v, rx, ry;
    Transfer(const Matrix& h, const Point& p) {
      const V z = h.row(2, p.x1, p.y1);
      inverse_z = z / (z * z + set(kTiny));
      u = h.row(0, p.x1, p.y1) * inverse_z;
      v = h.row(1, p.x1, p.y1) * inverse_z;
      rx = u - p.x2;
      ry = v - p.y2;
    }
    V residual(V w) const { return w * (rx * rx + ry * ry); }
  };

  template <class Residual>
  static float costAlone(const PointColumnsView& points, const Loss& loss, const Residual& residual) {
    Parts<V> sums;
    sums.forEach(0, points.size, [&](int i, V& cost) {
      const V e = residual(Point(points, i));
      cost += minimum(e, set(loss.cut)) * (set(1) / lossDivisor(loss, e));
    });
    return sums.total([](const V& cost) { return cost; });
  }

  static float epipolarCost(const PointColumnsView& points, const float (&M)[9], const Loss& loss) {
    const Matrix m(M);
    return costAlone(points, loss, [&m](const Point& p) { return Epipolar(m, p).residual(p.w); });
  }

  static float transferCost(const PointColumnsView& points, const float (&H)[9], const Loss& loss) {
    const Matrix h(H);
    return costAlone(points, loss, [&h](const Point& p) { return Transfer(h, p).residual(p.w); });
  }

  /// derivatives(point, image, Jx, Jy)
  template <int P, class Derivatives>
  static void linearizeTransfer(const PointColumnsView& points, const float (&H)[9], const Loss& loss,
                                NormalEquations<P>& equations, const Derivatives& derivatives) {
    const Matrix h(H);
    Parts<Equations<P>> sums;
    sums.forEach(0, points.size, [&](int i, Equations<P>& part) {
      const Point p(points, i);
      const Transfer moved(h, p);
      const V weight = p.w * lossWeight(loss, moved.residual(p.w), part);
      V Jx[P], Jy[P];
      derivatives(p, moved, Jx, Jy);
      part.add(Jx, moved.rx, weight);
      part.add(Jy, moved.ry, weight);
    });
    finish(sums, points, equations);
  }

  static void linearizeHomography(const PointColumnsView& points, const float (&H)[9], const float (&D)[8][9],
                                  const Loss& loss, NormalEquations<8>& equations) {
    V d[8][9];
    broadcast(D, d);
    linearizeTransfer(points, H, loss, equations, [&d](const Point& p, const Transfer& moved, V(&Jx)[8], V(&Jy)[8]) {
      for (int k = 0; k < 8; ++k) {
        const V a = d[k][0] * p.x1 + d[k][1] * p.y1 + d[k][2], b = d[k][3] * p.x1 + d[k][4] * p.y1 + d[k][5];
        const V c = d[k][6] * p.x1 + d[k][7] * p.y1 + d[k][8];
        Jx[k] = (a - moved.u * c) * moved.inverse_z;
        Jy[k] = (b - moved.v * c) * moved.inverse_z;
      }
    });
  }

  static void linearizeRotation(const PointColumnsView& points, const float (&R)[9], const Loss& loss,
                                NormalEquations<3>& equations) {
    linearizeTransfer(points, R, loss, equations, [](const Point&, const Transfer& moved, V(&Jx)[3], V(&Jy)[3]) {
      rotationDerivatives(moved.u, moved.v, Jx, Jy);
    });
  }

  template <V (*kFunction)(const V&)>
  static void apply(const float* x, float factor, int size, float* result) {
    for (int i = 0; i < size; i += kWidth) store(kFunction(set(factor) * load(x + i)), result + i);
  }

  static const ResidualKernels& table() {
    static const ResidualKernels kernels = {scoreEpipolar,        scorePose,
                                            scoreHomography,      linearizePose,
                                            differentiatePose,    sumProducts,
                                            linearizeFundamental, linearizeHomography,
                                            linearizeRotation,    poseCost,
                                            epipolarCost,         transferCost,
                                            epipolarResiduals,    poseResiduals,
                                            transferResiduals,    apply<exponential>,
                                            apply<logarithm>,     apply<errorFunction>};
    return kernels;
  }
};

}  // namespace
}  // namespace gms_ransac
