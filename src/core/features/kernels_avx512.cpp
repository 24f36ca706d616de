// The extractor's inner loops for AVX-512 (F, BW, VL, DQ, VBMI).
#if defined(__x86_64__)
#include <utility>

#include <immintrin.h>

#define GMS_RANSAC_VECTOR_BYTES 64
#include "features/kernels_impl.h"

namespace gms_ransac {
namespace {

struct Avx512 : Vectors {
  static constexpr bool kShuffles = true;

  static __m128i load128(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }
  static __mmask64 greater(U8 a, U8 b) { return _mm512_cmpgt_epu8_mask(__m512i(a), __m512i(b)); }

  static U8 subtract(U8 a, U8 b) { return U8(_mm512_subs_epu8(__m512i(a), __m512i(b))); }
  static U8 average(U8 a, U8 b) { return U8(_mm512_avg_epu8(__m512i(a), __m512i(b))); }
  static U8 addSaturated(U8 a, U8 b) { return U8(_mm512_adds_epu8(__m512i(a), __m512i(b))); }
  static bool anyGreater(U8 a, U8 b) { return greater(a, b) != 0; }
  static U8 keepGreater(U8 a, U8 b) { return U8(_mm512_maskz_mov_epi8(greater(a, b), __m512i(a))); }
  static uint64_t greaterMask(U8 a, U8 b) { return greater(a, b); }

  static int storeColumns(uint64_t mask, int x, uint16_t* columns) {
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    int count = 0;
    for (int i = 0; i < kBytes; i += 16, mask >>= 16) {
      const auto part = static_cast<__mmask16>(mask);
      const __m512i set = _mm512_maskz_compress_epi32(part, _mm512_add_epi32(lanes, _mm512_set1_epi32(x + i)));
      store(columns + count, _mm512_cvtepi32_epi16(set));
      count += _mm_popcnt_u32(part);
    }
    return count;
  }

  static U8 loadPart(const uint8_t* below, const uint8_t* above, int) {
    return U8(_mm512_inserti64x4(_mm512_castsi256_si512(loadAny<__m256i>(below)), loadAny<__m256i>(above), 1));
  }
  static I16 multiplyPairs(U8 a, const int8_t* b) { return I16(_mm512_maddubs_epi16(__m512i(a), loadAny<__m512i>(b))); }
  static I32 addPairs(I16 a) { return I32(_mm512_madd_epi16(__m512i(a), _mm512_set1_epi16(1))); }
  static int sum(I32 a) { return _mm512_reduce_add_epi32(__m512i(a)); }
  static __m512i loadWindows(const uint8_t* source, const int32_t* window) {
    return join([&](int i) { return load128(source + window[i]); });
  }
  static I16 shuffle(__m512i window, const uint8_t* positions) {
    return I16(_mm512_shuffle_epi8(window, __m512i(load(positions))));
  }
  static void storeBlend(uint8_t* p, I16 upper, I16 lower, int weight) {
    // Signed 16-bit products want values about zero: 32768 is taken off here and comes back, times 256, in the
    // rounding.
    const I16 middle = setHalves(INT16_MIN);
    const auto a = __m512i(upper ^ middle), b = __m512i(lower ^ middle);
    const __m512i weights = _mm512_set1_epi32(weight << 16 | (256 - weight));
    const __m512i rounding = _mm512_set1_epi32((1 << 23) + (1 << 15));
    const __m512i low = _mm512_add_epi32(_mm512_madd_epi16(_mm512_unpacklo_epi16(a, b), weights), rounding);
    const __m512i high = _mm512_add_epi32(_mm512_madd_epi16(_mm512_unpackhi_epi16(a, b), weights), rounding);
    store(p, _mm512_cvtepi16_epi8(_mm512_packus_epi32(_mm512_srli_epi32(low, 16), _mm512_srli_epi32(high, 16))));
  }

  static F32 loadAsFloats(const uint8_t* p) { return _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(load128(p))); }
  static F32 multiplyAdd(F32 a, F32 b, F32 c) { return _mm512_fmadd_ps(a, b, c); }
  static I32 rounded(F32 a) { return I32(_mm512_cvtps_epi32(a)); }
  static void storeRounded(uint8_t* p, F32 a) { store(p, _mm512_cvtusepi32_epi8(_mm512_cvtps_epi32(a))); }
  static I32 timesStride(I32 rows, int stride) {
    // Rows fit in 16 bits, strides nearly always: that product takes one instruction instead of two slow ones.
    return stride <= INT16_MAX ? I32(_mm512_madd_epi16(__m512i(rows), _mm512_set1_epi32(stride))) : rows * stride;
  }

  /// The pixels at 64 offsets, lowest bytes of what is gathered.
  static U8 gather(const uint8_t* centre, const int32_t* offsets) {
    return U8(join([&](int i) {
      return _mm512_cvtepi32_epi8(_mm512_i32gather_epi32(_mm512_loadu_si512(offsets + 16 * i), centre, 1));
    }));
  }
  static U8 readOneByOne(const uint8_t* centre, const int32_t* offsets) {
    return U8(
        join([&](int i) { return insertPixels(centre, offsets + 16 * i, std::make_integer_sequence<int, 16>()); }));
  }
  /// The pixels at one end of 64 tests, from those of kDistinctPattern.
  static U8 lookUp(const U8* pixels, int end, int test) {
    const auto place = __m512i(load(detail::kDistinctPattern.place[end] + test));
    const auto choose = [&](int i) {
      return _mm512_permutex2var_epi8(__m512i(pixels[2 * i]), place, __m512i(pixels[2 * i + 1]));
    };
    __m512i found = choose(0);
    for (int i = 1; i < detail::DistinctPattern::kTables; ++i) {
      found = _mm512_mask_mov_epi8(found, detail::kDistinctPattern.in_table[end][i][test / 64], choose(i));
    }
    return U8(found);
  }

 private:
  template <typename Quarter>
  static __m512i join(const Quarter& quarter) {
    const __m256i low = _mm256_set_m128i(quarter(1), quarter(0)), high = _mm256_set_m128i(quarter(3), quarter(2));
    return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
  }
  template <int... I>
  static __m128i insertPixels(const uint8_t* centre, const int32_t* offsets, std::integer_sequence<int, I...>) {
    __m128i pixels = _mm_setzero_si128();
    ((pixels = _mm_insert_epi8(pixels, centre[offsets[I]], I)), ...);
    return pixels;
  }
};

/// Intel's processors run byte extremes of 512 bits on one port, comparing into a mask and blending on the other: a mix
/// is a third faster than either. On an EPYC 9005 the contrasts take 1.45 times as long with it.
struct IntelAvx512 : Avx512 {
  static U8 otherMin(U8 a, U8 b) { return U8(_mm512_mask_mov_epi8(__m512i(a), greater(a, b), __m512i(b))); }
  static U8 otherMax(U8 a, U8 b) { return U8(_mm512_mask_mov_epi8(__m512i(a), greater(b, a), __m512i(b))); }
};

}  // namespace

const FeatureKernels& detail::avx512FeatureKernels(bool intel) {
  static const FeatureKernels kernels[2] = {kernelsOf<Avx512>(describeByLookUp<Avx512, Avx512::readOneByOne>),
                                            kernelsOf<IntelAvx512>(describeByLookUp<Avx512, Avx512::gather>)};
  return kernels[intel ? 1 : 0];
}

const FeatureKernels& detail::avx512FeatureKernels() {
  // AMD's gathers are microcode and slower than the loads: 166 ns a keypoint against 100 on an EPYC 9005. On a Sapphire
  // Rapids server gathers are ahead.
  return avx512FeatureKernels(!__builtin_cpu_is("amd"));
}

}  // namespace gms_ransac
#endif
