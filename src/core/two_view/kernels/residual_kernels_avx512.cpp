// The kernels for AVX-512.
#if defined(__AVX512F__)

// GCC 12's own header reads its undefined vectors and warns of it (GCC bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>

#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

namespace {

struct Vector {
  __m512 a;

  static Vector load(const float* p) { return {_mm512_load_ps(p)}; }
  static Vector set(float x) { return {_mm512_set1_ps(x)}; }
  void store(float* p) const { _mm512_storeu_ps(p, a); }
  static Vector minimum(const Vector& p, const Vector& q) { return {_mm512_min_ps(p.a, q.a)}; }
  static Vector maximum(const Vector& p, const Vector& q) { return {_mm512_max_ps(p.a, q.a)}; }
  static Vector select(const Vector& p, const Vector& q, const Vector& x, const Vector& y) {
    return {_mm512_mask_blend_ps(_mm512_cmp_ps_mask(p.a, q.a, _CMP_LT_OQ), y.a, x.a)};
  }
  static Vector squareRoot(const Vector& p) { return {_mm512_sqrt_ps(p.a)}; }
  float sum() const {
    const __m256 eight = _mm256_add_ps(_mm512_castps512_ps256(a), _mm512_extractf32x8_ps(a, 1));
    const __m128 four = _mm_add_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
    const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
  }
};

inline Vector operator+(const Vector& p, const Vector& q) { return {_mm512_add_ps(p.a, q.a)}; }
inline Vector operator-(const Vector& p, const Vector& q) { return {_mm512_sub_ps(p.a, q.a)}; }
inline Vector operator*(const Vector& p, const Vector& q) { return {_mm512_mul_ps(p.a, q.a)}; }
inline Vector operator/(const Vector& p, const Vector& q) { return {_mm512_div_ps(p.a, q.a)}; }

}  // namespace

const ResidualKernels& residualKernelsAvx512() { return KernelsFor<Vector>::table(); }

}  // namespace gms_ransac

#endif
