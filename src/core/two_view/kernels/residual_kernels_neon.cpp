// The kernels for NEON (64-bit ARM).
#if defined(__aarch64__)

#include <arm_neon.h>

#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

namespace {

struct Vector {
  float32x4_t v[4];

  static Vector load(const float* p) { return {{vld1q_f32(p), vld1q_f32(p + 4), vld1q_f32(p + 8), vld1q_f32(p + 12)}}; }
  static Vector set(float x) {
    const float32x4_t a = vdupq_n_f32(x);
    return {{a, a, a, a}};
  }
  void store(float* p) const {
    for (int i = 0; i < 4; ++i) vst1q_f32(p + 4 * i, v[i]);
  }
  // Not vminq and vmaxq: those return NaN where the comparison is false.
  static Vector minimum(const Vector& p, const Vector& q) { return select(p, q, p, q); }
  static Vector maximum(const Vector& p, const Vector& q) { return select(q, p, p, q); }
  static Vector select(const Vector& p, const Vector& q, const Vector& x, const Vector& y) {
    Vector r;
    for (int i = 0; i < 4; ++i) r.v[i] = vbslq_f32(vcltq_f32(p.v[i], q.v[i]), x.v[i], y.v[i]);
    return r;
  }
  static Vector squareRoot(const Vector& p) {
    Vector r;
    for (int i = 0; i < 4; ++i) r.v[i] = vsqrtq_f32(p.v[i]);
    return r;
  }
  float sum() const {
    const float32x4_t four = vaddq_f32(vaddq_f32(v[0], v[2]), vaddq_f32(v[1], v[3]));
    const float32x2_t two = vadd_f32(vget_low_f32(four), vget_high_f32(four));
    return vget_lane_f32(two, 0) + vget_lane_f32(two, 1);
  }
};

#define GMS_RANSAC_OPERATOR(op, intrinsic)                          \
  inline Vector operator op(const Vector& p, const Vector& q) {     \
    Vector r;                                                       \
    for (int i = 0; i < 4; ++i) r.v[i] = intrinsic(p.v[i], q.v[i]); \
    return r;                                                       \
  }
GMS_RANSAC_OPERATOR(+, vaddq_f32)
GMS_RANSAC_OPERATOR(-, vsubq_f32)
GMS_RANSAC_OPERATOR(*, vmulq_f32)
GMS_RANSAC_OPERATOR(/, vdivq_f32)
#undef GMS_RANSAC_OPERATOR

}  // namespace

const ResidualKernels& residualKernelsNeon() { return KernelsFor<Vector>::table(); }

}  // namespace gms_ransac

#endif
