// The extractor's inner loops for AVX-512 (F, BW, VL, DQ, VBMI).
#if defined(__x86_64__)
#include <utility>

#include <immintrin.h>

#include "features/kernels_impl.h"

namespace gms_ransac {
namespace {

struct Avx512 {
  static constexpr int kBytes = 64, kHalves = 32, kFloats = 16;
  static constexpr bool kShuffles = true;
  using U8 = __m512i;
  using I16 = __m512i;
  using F32 = __m512;

  static U8 load(const uint8_t* p) { return _mm512_loadu_si512(p); }
  static void store(uint8_t* p, U8 a) { _mm512_storeu_si512(p, a); }
  static U8 set(uint8_t a) { return _mm512_set1_epi8(static_cast<char>(a)); }
  static U8 min(U8 a, U8 b) { return _mm512_min_epu8(a, b); }
  static U8 max(U8 a, U8 b) { return _mm512_max_epu8(a, b); }
  static U8 otherMin(U8 a, U8 b) { return min(a, b); }
  static U8 otherMax(U8 a, U8 b) { return max(a, b); }
  static U8 subtract(U8 a, U8 b) { return _mm512_subs_epu8(a, b); }
  static U8 average(U8 a, U8 b) { return _mm512_avg_epu8(a, b); }
  static U8 addSaturated(U8 a, U8 b) { return _mm512_adds_epu8(a, b); }
  static bool anyGreater(U8 a, U8 b) { return _mm512_cmpgt_epu8_mask(a, b) != 0; }
  static U8 keepGreater(U8 a, U8 b) { return _mm512_maskz_mov_epi8(_mm512_cmpgt_epu8_mask(a, b), a); }
  static uint64_t greaterMask(U8 a, U8 b) { return _mm512_cmpgt_epu8_mask(a, b); }
  static uint64_t lessMask(U8 a, U8 b) { return _mm512_cmplt_epu8_mask(a, b); }

  static int storeColumns(uint64_t mask, int x, uint16_t* columns) {
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    int count = 0;
    for (int i = 0; i < kBytes; i += 16, mask >>= 16) {
      const auto part = static_cast<__mmask16>(mask);
      const __m512i set = _mm512_maskz_compress_epi32(part, _mm512_add_epi32(lanes, _mm512_set1_epi32(x + i)));
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(columns + count), _mm512_cvtepi32_epi16(set));
      count += _mm_popcnt_u32(part);
    }
    return count;
  }

  static I16 loadHalves(const uint16_t* p) { return _mm512_loadu_si512(p); }
  static void storeHalves(uint16_t* p, I16 a) { _mm512_storeu_si512(p, a); }
  static I16 loadSigned(const int16_t* p) { return _mm512_loadu_si512(p); }
  static I16 loadAsHalves(const uint8_t* p) {
    return _mm512_cvtepu8_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
  }
  static I16 setHalves(int16_t a) { return _mm512_set1_epi16(a); }
  static I16 bitAnd(I16 a, I16 b) { return _mm512_and_si512(a, b); }
  static I16 addHalves(I16 a, I16 b) { return _mm512_add_epi16(a, b); }
  static I16 subtractHalves(I16 a, I16 b) { return _mm512_sub_epi16(a, b); }
  static I16 multiplyHalves(I16 a, I16 b) { return _mm512_mullo_epi16(a, b); }
  static int dot(I16 a, I16 b) { return _mm512_reduce_add_epi32(_mm512_madd_epi16(a, b)); }
  static I16 loadWindows(const uint8_t* source, const int32_t* window) {
    const auto quarter = [&](int i) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(source + window[i])); };
    const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(quarter(0)), quarter(1), 1);
    const __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(quarter(2)), quarter(3), 1);
    return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
  }
  static I16 shuffle(I16 window, const uint8_t* positions) { return _mm512_shuffle_epi8(window, load(positions)); }
  static I16 blendBytes(I16 first, I16 second, I16 weight) {
    return _mm512_add_epi16(_mm512_slli_epi16(first, 8), _mm512_mullo_epi16(weight, _mm512_sub_epi16(second, first)));
  }
  static I16 blendHalves(I16 upper, I16 lower, int weight) {
    // Signed 16-bit products want values about zero: 32768 is taken off here and comes back, times 256, in the
    // rounding.
    const __m512i middle = _mm512_set1_epi16(-32768);
    const __m512i a = _mm512_xor_si512(upper, middle), b = _mm512_xor_si512(lower, middle);
    const __m512i weights = _mm512_set1_epi32(weight << 16 | (256 - weight));
    const __m512i rounding = _mm512_set1_epi32((1 << 23) + (1 << 15));
    const __m512i low = _mm512_add_epi32(_mm512_madd_epi16(_mm512_unpacklo_epi16(a, b), weights), rounding);
    const __m512i high = _mm512_add_epi32(_mm512_madd_epi16(_mm512_unpackhi_epi16(a, b), weights), rounding);
    return _mm512_packus_epi32(_mm512_srli_epi32(low, 16), _mm512_srli_epi32(high, 16));
  }
  static void storeNarrow(uint8_t* p, I16 a) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm512_cvtepi16_epi8(a));
  }

  static F32 setFloat(float a) { return _mm512_set1_ps(a); }
  static F32 loadFloats(const float* p) { return _mm512_loadu_ps(p); }
  static F32 loadAsFloats(const uint8_t* p) {
    return _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
  }
  static void storeFloats(float* p, F32 a) { _mm512_storeu_ps(p, a); }
  static F32 add(F32 a, F32 b) { return _mm512_add_ps(a, b); }
  static F32 subtractFloats(F32 a, F32 b) { return _mm512_sub_ps(a, b); }
  static F32 multiply(F32 a, F32 b) { return _mm512_mul_ps(a, b); }
  static F32 multiplyAdd(F32 a, F32 b, F32 c) { return _mm512_fmadd_ps(a, b, c); }
  static void storeRounded(uint8_t* p, F32 a) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm512_cvtusepi32_epi8(_mm512_cvtps_epi32(a)));
  }
  static __m512i offsets(F32 column, F32 row, int stride) {
    // Rows fit in 16 bits, strides nearly always: that product takes one instruction instead of two slow ones.
    const __m512i factor = _mm512_set1_epi32(stride), whole_row = _mm512_cvtps_epi32(row);
    const __m512i rows =
        stride <= INT16_MAX ? _mm512_madd_epi16(whole_row, factor) : _mm512_mullo_epi32(whole_row, factor);
    return _mm512_add_epi32(rows, _mm512_cvtps_epi32(column));
  }
  static void storeOffsets(int32_t* p, __m512i a) { _mm512_storeu_si512(p, a); }

  /// The pixels at 64 offsets, lowest bytes of what is gathered.
  static U8 gather(const uint8_t* centre, const int32_t* offsets) {
    return join([&](int i) { return _mm512_cvtepi32_epi8(_mm512_i32gather_epi32(load(offsets + 16 * i), centre, 1)); });
  }
  static U8 readOneByOne(const uint8_t* centre, const int32_t* offsets) {
    return join([&](int i) { return insertPixels(centre, offsets + 16 * i, std::make_integer_sequence<int, 16>()); });
  }
  /// The pixels at one end of 64 tests, from those of kDistinctPattern.
  static U8 lookUp(const U8* pixels, int end, int test) {
    const U8 place = load(detail::kDistinctPattern.place[end] + test);
    U8 found = _mm512_permutex2var_epi8(pixels[0], place, pixels[1]);
    for (int i = 1; i < detail::DistinctPattern::kTables; ++i) {
      const __mmask64 mask = detail::kDistinctPattern.in_table[end][i][test / 64];
      found = _mm512_mask_mov_epi8(found, mask, _mm512_permutex2var_epi8(pixels[2 * i], place, pixels[2 * i + 1]));
    }
    return found;
  }

 private:
  static U8 load(const int32_t* p) { return _mm512_loadu_si512(p); }
  template <typename Quarter>
  static U8 join(const Quarter& quarter) {
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
  static U8 otherMin(U8 a, U8 b) { return _mm512_mask_mov_epi8(a, _mm512_cmplt_epu8_mask(b, a), b); }
  static U8 otherMax(U8 a, U8 b) { return _mm512_mask_mov_epi8(a, _mm512_cmpgt_epu8_mask(b, a), b); }
};

void describeGathering(const uint8_t* centre, ptrdiff_t stride, float cosine, float sine, uint8_t* descriptor) {
  describeByLookUp<Avx512>(stride, cosine, sine, descriptor,
                           [&](const int32_t* offsets) { return Avx512::gather(centre, offsets); });
}

void describeOneByOne(const uint8_t* centre, ptrdiff_t stride, float cosine, float sine, uint8_t* descriptor) {
  describeByLookUp<Avx512>(stride, cosine, sine, descriptor,
                           [&](const int32_t* offsets) { return Avx512::readOneByOne(centre, offsets); });
}

}  // namespace

const FeatureKernels& detail::avx512FeatureKernels(bool intel) {
  static const FeatureKernels kernels[2] = {kernelsOf<Avx512>(describeOneByOne),
                                            kernelsOf<IntelAvx512>(describeGathering)};
  return kernels[intel ? 1 : 0];
}

const FeatureKernels& detail::avx512FeatureKernels() {
  // AMD's gathers are microcode and slower than the loads: 166 ns a keypoint against 100 on an EPYC 9005. On a Sapphire
  // Rapids server gathers are ahead.
  return avx512FeatureKernels(!__builtin_cpu_is("amd"));
}

}  // namespace gms_ransac
#endif
