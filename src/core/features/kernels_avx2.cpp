// The extractor's inner loops for AVX2.
#if defined(__x86_64__)
#include <immintrin.h>

#define GMS_RANSAC_VECTOR_BYTES 32
#include "features/kernels_impl.h"

namespace gms_ransac {
namespace {

struct Avx2 : Vectors {
  static constexpr bool kShuffles = true;

  static __m128i load128(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }

  static U8 subtract(U8 a, U8 b) { return U8(_mm256_subs_epu8(__m256i(a), __m256i(b))); }
  static U8 average(U8 a, U8 b) { return U8(_mm256_avg_epu8(__m256i(a), __m256i(b))); }
  static U8 addSaturated(U8 a, U8 b) { return U8(_mm256_adds_epu8(__m256i(a), __m256i(b))); }
  static bool anyGreater(U8 a, U8 b) {
    const auto excess = __m256i(subtract(a, b));
    return !_mm256_testz_si256(excess, excess);
  }
  static uint64_t greaterMask(U8 a, U8 b) { return static_cast<uint32_t>(_mm256_movemask_epi8(__m256i(a > b))); }

  template <int... i>
  [[gnu::always_inline]] static U8 read(const uint8_t* centre, const int32_t* offsets, const uint16_t* numbers,
                                        std::integer_sequence<int, i...>) {
    U8 pixels{};
    ((pixels[i] = centre[offsets[numbers[i]]]), ...);  // two instructions each
    return pixels;
  }

  static I16 multiplyPairs(U8 a, const int8_t* b) { return I16(_mm256_maddubs_epi16(__m256i(a), loadAny<__m256i>(b))); }
  static I32 addPairs(I16 a) { return I32(_mm256_madd_epi16(__m256i(a), _mm256_set1_epi16(1))); }
  static int sum(I32 a) {
    const auto sums = __m256i(a);
    __m128i sum = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0x4e));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xb1));
    return _mm_cvtsi128_si32(sum);
  }
  static __m256i loadWindows(const uint8_t* source, const int32_t* window) {
    return _mm256_set_m128i(load128(source + window[1]), load128(source + window[0]));
  }
  static I16 shuffle(__m256i window, const uint8_t* positions) {
    return I16(_mm256_shuffle_epi8(window, __m256i(load(positions))));
  }
  static void storeBlend(uint8_t* p, I16 upper, I16 lower, int weight) {
    // Signed 16-bit products want values about zero: 32768 is taken off here and comes back, times 256, in the
    // rounding.
    const I16 middle = setHalves(INT16_MIN);
    const auto a = __m256i(upper ^ middle), b = __m256i(lower ^ middle);
    const __m256i weights = _mm256_set1_epi32(weight << 16 | (256 - weight));
    const __m256i rounding = _mm256_set1_epi32((1 << 23) + (1 << 15));
    const __m256i low = _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpacklo_epi16(a, b), weights), rounding);
    const __m256i high = _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpackhi_epi16(a, b), weights), rounding);
    const __m256i blend = _mm256_packus_epi32(_mm256_srli_epi32(low, 16), _mm256_srli_epi32(high, 16));
    store(p, _mm256_castsi256_si128(_mm256_permute4x64_epi64(_mm256_packus_epi16(blend, blend), 0x08)));
  }

  static F32 loadAsFloats(const uint8_t* p) {
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
  }
  static F32 multiplyAdd(F32 a, F32 b, F32 c) { return _mm256_fmadd_ps(a, b, c); }
  static I32 rounded(F32 a) { return I32(_mm256_cvtps_epi32(a)); }
  static void storeRounded(uint8_t* p, F32 a) {
    const __m256i words = _mm256_cvtps_epi32(a);
    const __m128i halves = _mm_packus_epi32(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(p), _mm_packus_epi16(halves, halves));
  }
};

/// FeatureKernels::compareRow at 16 places together: one instruction adds up the differences of four columns.
void compareFourColumns(const uint8_t* left, const uint8_t* right, ptrdiff_t stride, int count, int16_t* sums) {
  static_assert(kRowWindowWidth == 2 * 4 + 1);
  constexpr int kEight = 8, kFirstFour = 0, kNextFour = 0b101101;  // of both, in both halves of a register
  __m256i window[kRowWindowHeight];
  __m128i last[kRowWindowHeight];
  for (int y = 0; y < kRowWindowHeight; ++y) {
    window[y] = _mm256_broadcastsi128_si256(Avx2::load128(left + y * stride));
    last[y] = _mm_set1_epi8(static_cast<char>(left[y * stride + kEight]));
  }
  for (int k = 0; k < count; k += 2 * kEight) {
    __m256i sum = _mm256_setzero_si256();
    for (int y = 0; y < kRowWindowHeight; ++y) {
      const uint8_t* row = right + y * stride + k;
      const __m128i further = Avx2::load128(row + kEight);
      const __m256i places = _mm256_set_m128i(further, Avx2::load128(row));
      const __m128i of_last = _mm_sub_epi8(_mm_max_epu8(further, last[y]), _mm_min_epu8(further, last[y]));
      sum = _mm256_add_epi16(sum, _mm256_mpsadbw_epu8(places, window[y], kFirstFour));
      sum = _mm256_add_epi16(sum, _mm256_mpsadbw_epu8(places, window[y], kNextFour));
      sum = _mm256_add_epi16(sum, _mm256_cvtepu8_epi16(of_last));
    }
    Avx2::store(sums + k, sum);
  }
}

}  // namespace

const FeatureKernels& detail::avx2FeatureKernels() {
  static const FeatureKernels kernels = kernelsOf<Avx2>(describe<Avx2>, compareFourColumns);
  return kernels;
}

}  // namespace gms_ransac
#endif
