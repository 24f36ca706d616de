// Brute force for processors with AVX-512 VBMI and GFNI (Ice Lake, Zen 4 and later).
//
// The train descriptors are stored as 42 rows of 6-bit fields and one of 4 bits, 64 descriptors a vector. A field and a
// query's 64-entry table give the number of differing bits in one byte permutation, without xor or popcount. Tables
// hold two queries, one in each half of the byte: two fields add up to at most 12, so halves do not mix before they are
// split. That is 6 instructions for 12 bits of 64 descriptors and two queries, a third fewer than xor, VPOPCNT, add.
#if defined(__AVX512VBMI__)
#include <immintrin.h>

// GCC 12's own AVX-512 headers read undefined vectors on purpose and are warned about where they are inlined.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

#include "matching/hamming_blocked.h"

namespace gms_ransac {
namespace {

struct Avx512 {
  using Vector = __m512i;
  static constexpr int kLanes = 64;
  static constexpr int kFields = 42;         ///< of 6 bits
  static constexpr int kRows = kFields + 1;  ///< and one of 4
  static constexpr int kPairs = kQueryGroup / 2;
  static constexpr int kBlockBytes = kVectors * kRows * kLanes;

  struct alignas(64) Tables {
    uint8_t count[kPairs][kRows][kLanes];
  };

  static Vector load(const void* p) { return _mm512_load_si512(p); }
  static void store(void* p, Vector v) { _mm512_store_si512(p, v); }
  static Vector min(Vector a, Vector b) { return _mm512_min_epu8(a, b); }
  static Vector max(Vector a, Vector b) { return _mm512_max_epu8(a, b); }
  static Vector broadcast(int value) { return _mm512_set1_epi8(static_cast<char>(value)); }
  static Vector selectLess(Vector a, Vector b, Vector less, Vector otherwise) {
    return _mm512_mask_mov_epi8(otherwise, _mm512_cmplt_epu8_mask(a, b), less);
  }

  static int field(const uint8_t* row, int f) {
    if (f == kFields) return row[kHammingBytes - 1] >> 4;
    const int bit = 6 * f;
    return ((row[bit / 8] | row[bit / 8 + 1] << 8) >> bit % 8) & 63;
  }

  static void packOne(const uint8_t* row, uint8_t* block, int vector, int lane) {
    uint8_t* to = block + static_cast<size_t>(vector) * kRows * kLanes + lane;
    for (int f = 0; f < kRows; ++f) to[f * kLanes] = static_cast<uint8_t>(field(row, f));
  }

  /// Differing bits of the 6-bit number with every 6-bit number.
  static Vector differences(int number) {
    alignas(64) static constexpr uint8_t kNumbers[64] = {
        0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21,
        22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 37, 38, 39, 40, 41, 42, 43,
        44, 45, 46, 47, 48, 49, 50, 51, 52, 53, 54, 55, 56, 57, 58, 59, 60, 61, 62, 63};
    return _mm512_popcnt_epi8(_mm512_xor_si512(load(kNumbers), broadcast(number)));
  }

  static void setQuery(Tables& tables, int q, const uint8_t* row) {
    for (int f = 0; f < kRows; ++f) {
      uint8_t* table = tables.count[q / 2][f];
      const Vector count = differences(field(row, f));
      store(table, q % 2 == 0 ? count : _mm512_or_si512(load(table), _mm512_slli_epi16(count, 4)));
    }
  }

  static Vector upperHalves(Vector v) {
    return _mm512_gf2p8affine_epi64_epi8(v, _mm512_set1_epi64(0x1020408000000000), 0);
  }

  template <bool kReverse>
  static void distances(const Tables& tables, const uint8_t* packed, int left, int group, uint8_t* minimum,
                        uint8_t* groups, Vector* block_minimum) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      const uint8_t* fields = packed + v * kRows * kLanes;
      Vector sum[kPairs], upper[kPairs];
#pragma GCC unroll 4
      for (int p = 0; p < kPairs; ++p) sum[p] = upper[p] = _mm512_setzero_si512();
#pragma GCC unroll 1
      for (int f = 0; f < kFields; f += 2) {
        const Vector a = load(fields + f * kLanes), b = load(fields + (f + 1) * kLanes);
#pragma GCC unroll 4
        for (int p = 0; p < kPairs; ++p) {
          const Vector both = _mm512_add_epi8(_mm512_permutexvar_epi8(a, load(tables.count[p][f])),
                                              _mm512_permutexvar_epi8(b, load(tables.count[p][f + 1])));
          sum[p] = _mm512_add_epi8(sum[p], both);
          upper[p] = _mm512_add_epi8(upper[p], upperHalves(both));
        }
      }
      const Vector last = load(fields + kFields * kLanes);
      const Vector low_half = _mm512_set1_epi8(15);
      const __mmask64 padding = paddingMask(v, left);
      Vector smallest = _mm512_set1_epi8(-1);
#pragma GCC unroll 4
      for (int p = 0; p < kPairs; ++p) {
        const Vector both = _mm512_permutexvar_epi8(last, load(tables.count[p][kFields]));
        // sum = first query + 16 second query, modulo 256.
        Vector first = _mm512_sub_epi8(sum[p], _mm512_slli_epi16(_mm512_and_si512(upper[p], low_half), 4));
        first = _mm512_adds_epu8(first, _mm512_and_si512(both, low_half));
        Vector second = _mm512_adds_epu8(upper[p], upperHalves(both));
        if (padding) {
          first = _mm512_mask_mov_epi8(first, padding, _mm512_set1_epi8(-1));
          second = _mm512_mask_mov_epi8(second, padding, _mm512_set1_epi8(-1));
        }
        block_minimum[2 * p] = v == 0 ? first : min(block_minimum[2 * p], first);
        block_minimum[2 * p + 1] = v == 0 ? second : min(block_minimum[2 * p + 1], second);
        if (kReverse) smallest = min(smallest, min(first, second));
      }
      if (kReverse) {
        uint8_t* lane_minimum = minimum + v * kLanes;
        uint8_t* lane_group = groups + v * kLanes;
        const Vector old = load(lane_minimum);
        store(lane_group, selectLess(smallest, old, broadcast(group), load(lane_group)));
        store(lane_minimum, min(smallest, old));
      }
    }
  }

  /// Lanes of one vector of a block with `left` descriptors that hold none.
  static __mmask64 paddingMask(int vector, int left) {
    if (left >= kVectors * kLanes) return 0;
    const int used = std::max(0, (left - vector + kVectors - 1) / kVectors);
    return used >= kLanes ? 0 : ~__mmask64{0} << used;
  }

  static int smallestByte(Vector v) {
    const __m256i half = _mm256_min_epu8(_mm512_castsi512_si256(v), _mm512_extracti64x4_epi64(v, 1));
    const __m128i quarter = _mm_min_epu8(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1));
    return _mm_cvtsi128_si32(_mm_minpos_epu16(_mm_min_epu8(quarter, _mm_srli_epi16(quarter, 8)))) & 255;
  }

  /// Smallest of `best`, on ties the one with the lowest block, then lane; `second` is the next in any lane.
  static int reduce(const uint8_t* best, const uint8_t* second_best, const uint8_t* block, int& lane, int& second) {
    const Vector bests = load(best);
    const int smallest = smallestByte(bests);
    __mmask64 tied = _mm512_cmpeq_epu8_mask(bests, broadcast(smallest));
    if (tied & (tied - 1)) {
      const Vector blocks = _mm512_mask_mov_epi8(_mm512_set1_epi8(-1), tied, load(block));
      tied &= _mm512_cmpeq_epu8_mask(blocks, broadcast(smallestByte(blocks)));
    }
    lane = __builtin_ctzll(tied);
    const Vector others = _mm512_mask_mov_epi8(bests, __mmask64{1} << lane, _mm512_set1_epi8(-1));
    second = std::min(smallestByte(others), static_cast<int>(second_best[lane]));
    return smallest;
  }
};

}  // namespace

const HammingKernel kHammingKernelAvx512 = Blocked<Avx512>::kernel();

}  // namespace gms_ransac
#endif
