// The extractor's inner loops for AVX2.
#if defined(__x86_64__)
#include <immintrin.h>

#include "features/kernels_impl.h"

namespace gms_ransac {
namespace {

struct Avx2 {
  static constexpr int kBytes = 32, kHalves = 16, kFloats = 8;
  static constexpr bool kShuffles = true;
  using U8 = __m256i;
  using I16 = __m256i;
  using F32 = __m256;

  static __m256i loadAny(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }
  static void storeAny(void* p, __m256i a) { _mm256_storeu_si256(static_cast<__m256i*>(p), a); }

  static U8 load(const uint8_t* p) { return loadAny(p); }
  static void store(uint8_t* p, U8 a) { storeAny(p, a); }
  static U8 set(uint8_t a) { return _mm256_set1_epi8(static_cast<char>(a)); }
  static U8 min(U8 a, U8 b) { return _mm256_min_epu8(a, b); }
  static U8 max(U8 a, U8 b) { return _mm256_max_epu8(a, b); }
  static U8 otherMin(U8 a, U8 b) { return min(a, b); }
  static U8 otherMax(U8 a, U8 b) { return max(a, b); }
  static U8 subtract(U8 a, U8 b) { return _mm256_subs_epu8(a, b); }
  static U8 notGreater(U8 a, U8 b) { return _mm256_cmpeq_epi8(subtract(a, b), _mm256_setzero_si256()); }
  static U8 average(U8 a, U8 b) { return _mm256_avg_epu8(a, b); }
  static U8 addSaturated(U8 a, U8 b) { return _mm256_adds_epu8(a, b); }
  static bool anyGreater(U8 a, U8 b) {
    const U8 excess = subtract(a, b);
    return !_mm256_testz_si256(excess, excess);
  }
  static U8 keepGreater(U8 a, U8 b) { return _mm256_andnot_si256(notGreater(a, b), a); }
  static uint64_t greaterMask(U8 a, U8 b) { return ~static_cast<uint32_t>(_mm256_movemask_epi8(notGreater(a, b))); }

  static int storeColumns(uint64_t mask, int x, uint16_t* columns) { return storeSetBits(mask, x, columns); }

  static I16 loadHalves(const uint16_t* p) { return loadAny(p); }
  static void storeHalves(uint16_t* p, I16 a) { storeAny(p, a); }
  static I16 loadSigned(const int16_t* p) { return loadAny(p); }
  static I16 loadAsHalves(const uint8_t* p) {
    return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
  }
  static I16 setHalves(int16_t a) { return _mm256_set1_epi16(a); }
  static I16 bitAnd(I16 a, I16 b) { return _mm256_and_si256(a, b); }
  static I16 addHalves(I16 a, I16 b) { return _mm256_add_epi16(a, b); }
  static I16 subtractHalves(I16 a, I16 b) { return _mm256_sub_epi16(a, b); }
  static I16 multiplyHalves(I16 a, I16 b) { return _mm256_mullo_epi16(a, b); }
  static int dot(I16 a, I16 b) {
    const __m256i sums = _mm256_madd_epi16(a, b);
    __m128i sum = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0x4e));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xb1));
    return _mm_cvtsi128_si32(sum);
  }
  static I16 loadWindows(const uint8_t* source, const int32_t* window) {
    const auto low = _mm_loadu_si128(reinterpret_cast<const __m128i*>(source + window[0]));
    const auto high = _mm_loadu_si128(reinterpret_cast<const __m128i*>(source + window[1]));
    return _mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1);
  }
  static I16 shuffle(I16 window, const uint8_t* positions) { return _mm256_shuffle_epi8(window, loadAny(positions)); }
  static I16 blendBytes(I16 first, I16 second, I16 weight) {
    return _mm256_add_epi16(_mm256_slli_epi16(first, 8), _mm256_mullo_epi16(weight, _mm256_sub_epi16(second, first)));
  }
  static I16 blendHalves(I16 upper, I16 lower, int weight) {
    // Signed 16-bit products want values about zero: 32768 is taken off here and comes back, times 256, in the
    // rounding.
    const __m256i middle = _mm256_set1_epi16(-32768);
    const __m256i a = _mm256_xor_si256(upper, middle), b = _mm256_xor_si256(lower, middle);
    const __m256i weights = _mm256_set1_epi32(weight << 16 | (256 - weight));
    const __m256i rounding = _mm256_set1_epi32((1 << 23) + (1 << 15));
    const __m256i low = _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpacklo_epi16(a, b), weights), rounding);
    const __m256i high = _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpackhi_epi16(a, b), weights), rounding);
    return _mm256_packus_epi32(_mm256_srli_epi32(low, 16), _mm256_srli_epi32(high, 16));
  }
  static void storeNarrow(uint8_t* p, I16 a) {
    const __m256i bytes = _mm256_permute4x64_epi64(_mm256_packus_epi16(a, a), 0x08);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm256_castsi256_si128(bytes));
  }

  static F32 setFloat(float a) { return _mm256_set1_ps(a); }
  static F32 loadFloats(const float* p) { return _mm256_loadu_ps(p); }
  static F32 loadAsFloats(const uint8_t* p) {
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
  }
  static void storeFloats(float* p, F32 a) { _mm256_storeu_ps(p, a); }
  static F32 add(F32 a, F32 b) { return _mm256_add_ps(a, b); }
  static F32 subtractFloats(F32 a, F32 b) { return _mm256_sub_ps(a, b); }
  static F32 multiply(F32 a, F32 b) { return _mm256_mul_ps(a, b); }
  static F32 multiplyAdd(F32 a, F32 b, F32 c) { return _mm256_fmadd_ps(a, b, c); }
  static void storeRounded(uint8_t* p, F32 a) {
    const __m256i words = _mm256_cvtps_epi32(a);
    const __m128i halves = _mm_packus_epi32(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(p), _mm_packus_epi16(halves, halves));
  }
  static __m256i offsets(F32 column, F32 row, int stride) {
    const __m256i rows = _mm256_mullo_epi32(_mm256_cvtps_epi32(row), _mm256_set1_epi32(stride));
    return _mm256_add_epi32(rows, _mm256_cvtps_epi32(column));
  }
  static void storeOffsets(int32_t* p, __m256i a) { storeAny(p, a); }
};

}  // namespace

const FeatureKernels& detail::avx2FeatureKernels() {
  static const FeatureKernels kernels = kernelsOf<Avx2>();
  return kernels;
}

}  // namespace gms_ransac
#endif
