// The kernels in plain C++, and the choice among the instruction sets.
#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

const ResidualKernels& residualKernelsAvx2();
const ResidualKernels& residualKernelsAvx512();
const ResidualKernels& residualKernelsNeon();

namespace {

struct Vector {
  float v[kLanes];

  static Vector load(const float* p) {
    Vector r;
    for (int i = 0; i < kLanes; ++i) r.v[i] = p[i];
    return r;
  }
  static Vector set(float a) {
    Vector r;
    for (float& x : r.v) x = a;
    return r;
  }
  void store(float* p) const {
    for (int i = 0; i < kLanes; ++i) p[i] = v[i];
  }
  static Vector minimum(const Vector& a, const Vector& b) { return select(a, b, a, b); }
  static Vector maximum(const Vector& a, const Vector& b) { return select(b, a, a, b); }
  static Vector select(const Vector& a, const Vector& b, const Vector& x, const Vector& y) {
    Vector r;
    for (int i = 0; i < kLanes; ++i) r.v[i] = a.v[i] < b.v[i] ? x.v[i] : y.v[i];
    return r;
  }
  static Vector squareRoot(const Vector& a) {
    Vector r;
    for (int i = 0; i < kLanes; ++i) r.v[i] = __builtin_sqrtf(a.v[i]);
    return r;
  }
  float sum() const {
    float half[8];
    for (int i = 0; i < 8; ++i) half[i] = v[i] + v[i + 8];
    for (int i = 0; i < 4; ++i) half[i] = half[i] + half[i + 4];
    return (half[0] + half[2]) + (half[1] + half[3]);
  }
};

#define GMS_RANSAC_OPERATOR(op)                                 \
  Vector operator op(const Vector& a, const Vector& b) {        \
    Vector r;                                                   \
    for (int i = 0; i < kLanes; ++i) r.v[i] = a.v[i] op b.v[i]; \
    return r;                                                   \
  }
GMS_RANSAC_OPERATOR(+)
GMS_RANSAC_OPERATOR(-)
GMS_RANSAC_OPERATOR(*)
GMS_RANSAC_OPERATOR(/)
#undef GMS_RANSAC_OPERATOR

}  // namespace

const ResidualKernels& residualKernels(SimdLevel level) {
  switch (level) {
#if defined(__x86_64__)
    case SimdLevel::kAvx512:
      return residualKernelsAvx512();
    case SimdLevel::kAvx2:
      return residualKernelsAvx2();
#elif defined(__aarch64__)
    case SimdLevel::kNeon:
      return residualKernelsNeon();
#endif
    default:
      return KernelsFor<Vector>::table();
  }
}

}  // namespace gms_ransac
