// The kernels for any processor, over vectors of four floats, and the choice among the instruction sets. The compiler
// turns them into the processor's own: SSE2 on x86, NEON on ARM, single numbers elsewhere.
#include <cmath>
#include <cstring>

#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

const ResidualKernels& residualKernelsAvx2();
const ResidualKernels& residualKernelsAvx512();

namespace {

struct Vector {
  using Four [[gnu::vector_size(4 * sizeof(float))]] = float;
  static constexpr int kFours = kLanes / 4;
  Four v[kFours];

  /// of(f): f(i) for each four.
  template <typename Make>
  [[gnu::always_inline]] static Vector of(const Make& make) {
    Vector r;
    for (int i = 0; i < kFours; ++i) r.v[i] = make(i);
    return r;
  }
  [[gnu::always_inline]] static Vector load(const float* p) {
    Vector r;
    std::memcpy(r.v, p, sizeof r.v);
    return r;
  }
  [[gnu::always_inline]] static Vector set(float a) {
    return of([a](int) { return Four{a, a, a, a}; });
  }
  void store(float* p) const { std::memcpy(p, v, sizeof v); }
  [[gnu::always_inline]] static Vector select(const Vector& a, const Vector& b, const Vector& x, const Vector& y) {
    return of([&](int i) { return a.v[i] < b.v[i] ? x.v[i] : y.v[i]; });
  }
  static Vector minimum(const Vector& a, const Vector& b) { return select(a, b, a, b); }
  static Vector maximum(const Vector& a, const Vector& b) { return select(b, a, a, b); }
  static Vector squareRoot(const Vector& a) {
    float lanes[kLanes];
    a.store(lanes);
    for (float& x : lanes) x = std::sqrt(x);
    return load(lanes);
  }
  float sum() const {
    const Four four = (v[0] + v[2]) + (v[1] + v[3]);
    return (four[0] + four[2]) + (four[1] + four[3]);
  }
};

#define GMS_RANSAC_OPERATOR(op)                                                        \
  [[gnu::always_inline]] inline Vector operator op(const Vector& a, const Vector& b) { \
    return Vector::of([&](int i) { return a.v[i] op b.v[i]; });                        \
  }
GMS_RANSAC_OPERATOR(+)
GMS_RANSAC_OPERATOR(-)
GMS_RANSAC_OPERATOR(*)
GMS_RANSAC_OPERATOR(/)
#undef GMS_RANSAC_OPERATOR

}  // namespace

const ResidualKernels& residualKernels([[maybe_unused]] SimdLevel level) {
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512) return residualKernelsAvx512();
  if (level == SimdLevel::kAvx2) return residualKernelsAvx2();
#endif
  return KernelsFor<Vector>::table();
}

}  // namespace gms_ransac
