// The kernels for AVX2.
#if defined(__AVX2__)

#include <immintrin.h>

#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

namespace {

struct Vector {
  __m256 a, b;

  static Vector load(const float* p) { return {_mm256_load_ps(p), _mm256_load_ps(p + 8)}; }
  static Vector set(float x) { return {_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
  void store(float* p) const {
    _mm256_storeu_ps(p, a);
    _mm256_storeu_ps(p + 8, b);
  }
  static Vector minimum(const Vector& p, const Vector& q) { return {_mm256_min_ps(p.a, q.a), _mm256_min_ps(p.b, q.b)}; }
  static Vector maximum(const Vector& p, const Vector& q) { return {_mm256_max_ps(p.a, q.a), _mm256_max_ps(p.b, q.b)}; }
  static Vector select(const Vector& p, const Vector& q, const Vector& x, const Vector& y) {
    return {_mm256_blendv_ps(y.a, x.a, _mm256_cmp_ps(p.a, q.a, _CMP_LT_OQ)),
            _mm256_blendv_ps(y.b, x.b, _mm256_cmp_ps(p.b, q.b, _CMP_LT_OQ))};
  }
  static Vector squareRoot(const Vector& p) { return {_mm256_sqrt_ps(p.a), _mm256_sqrt_ps(p.b)}; }
  float sum() const {
    const __m256 eight = _mm256_add_ps(a, b);
    const __m128 four = _mm_add_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
    const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
  }
};

inline Vector operator+(const Vector& p, const Vector& q) { return {_mm256_add_ps(p.a, q.a), _mm256_add_ps(p.b, q.b)}; }
inline Vector operator-(const Vector& p, const Vector& q) { return {_mm256_sub_ps(p.a, q.a), _mm256_sub_ps(p.b, q.b)}; }
inline Vector operator*(const Vector& p, const Vector& q) { return {_mm256_mul_ps(p.a, q.a), _mm256_mul_ps(p.b, q.b)}; }
inline Vector operator/(const Vector& p, const Vector& q) { return {_mm256_div_ps(p.a, q.a), _mm256_div_ps(p.b, q.b)}; }

}  // namespace

const ResidualKernels& residualKernelsAvx2() { return KernelsFor<Vector>::table(); }

}  // namespace gms_ransac

#endif
