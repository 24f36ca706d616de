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
#pragma GCC diagnostic ignored "-Wuninitialized"

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

  /// The 6-bit fields of a descriptor in its first kRows bytes.
  static Vector fields(const uint8_t* row) {
    // Eight fields are six bytes: those go to one 64-bit word, from which they are picked at every sixth bit.
    alignas(64) static constexpr uint8_t kSixBytes[64] = {0,  1,  2,  3,  4,  5,  0, 0, 6,  7,  8,  9,  10, 11, 0, 0,
                                                          12, 13, 14, 15, 16, 17, 0, 0, 18, 19, 20, 21, 22, 23, 0, 0,
                                                          24, 25, 26, 27, 28, 29, 0, 0, 30, 31, 32, 32, 32, 32, 0, 0};
    constexpr uint64_t kEverySixthBit = 0x2a241e18120c0600;
    const Vector bytes = _mm512_maskz_loadu_epi64(0x0f, row);
    const Vector words = _mm512_permutexvar_epi8(load(kSixBytes), bytes);
    const Vector picked = _mm512_multishift_epi64_epi8(_mm512_set1_epi64(kEverySixthBit), words);
    return _mm512_and_si512(picked, _mm512_set1_epi8(63));
  }

  /// Transposes the fields of a block's descriptors, eight descriptors by eight fields at a time.
  static void packBlock(const uint8_t* rows, int count, uint8_t* block) {
    alignas(64) static constexpr uint8_t kTranspose[64] = {
        0,  8,  16, 24, 32, 40, 48, 56, 1,  9,  17, 25, 33, 41, 49, 57, 2,  10, 18, 26, 34, 42,
        50, 58, 3,  11, 19, 27, 35, 43, 51, 59, 4,  12, 20, 28, 36, 44, 52, 60, 5,  13, 21, 29,
        37, 45, 53, 61, 6,  14, 22, 30, 38, 46, 54, 62, 7,  15, 23, 31, 39, 47, 55, 63};
    constexpr int kDescriptors = 8;
    alignas(64) uint8_t by_descriptor[kDescriptors][64];
    alignas(64) uint8_t by_field[64];
    for (int v = 0; v < kVectors; ++v) {
      for (int lane = 0; lane < kLanes; lane += kDescriptors) {
        for (int d = 0; d < kDescriptors; ++d) {
          // Lanes past the end repeat the last descriptor: what they hold is masked when it is read.
          const int k = std::min((lane + d) * kVectors + v, count - 1);
          store(by_descriptor[d], fields(rows + static_cast<size_t>(k) * kHammingBytes));
        }
        for (int f = 0; f < kRows; f += 8) {
          const __m512i starts = _mm512_setr_epi64(0, 64, 128, 192, 256, 320, 384, 448);
          const Vector gathered = _mm512_i64gather_epi64(starts, &by_descriptor[0][f], 1);
          store(by_field, _mm512_permutexvar_epi8(load(kTranspose), gathered));
          uint8_t* to = block + (static_cast<size_t>(v) * kRows + f) * kLanes + lane;
          for (int k = 0; k < std::min(8, kRows - f); ++k) std::memcpy(to + k * kLanes, by_field + 8 * k, 8);
        }
      }
    }
  }

  /// Entry [a][b]: differing bits of two 6-bit numbers.
  struct alignas(64) Differences {
    uint8_t count[64][64] = {};
    constexpr Differences() {
      for (int a = 0; a < 64; ++a) {
        for (int b = 0; b < 64; ++b) {
          for (int bit = 0; bit < 6; ++bit) count[a][b] = static_cast<uint8_t>(count[a][b] + ((a ^ b) >> bit & 1));
        }
      }
    }
  };

  static void setQueries(Tables& tables, int pair, const uint8_t* first, const uint8_t* second) {
    static constexpr Differences kDifferences;
    alignas(64) uint8_t first_field[64], second_field[64];
    store(first_field, fields(first));
    store(second_field, fields(second));
#pragma GCC unroll 4
    for (int f = 0; f < kRows; ++f) {
      const Vector upper = _mm512_slli_epi16(load(kDifferences.count[second_field[f]]), 4);
      store(tables.count[pair][f], _mm512_or_si512(load(kDifferences.count[first_field[f]]), upper));
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
    const Vector blocks = _mm512_mask_mov_epi8(_mm512_set1_epi8(-1), tied, load(block));
    tied &= _mm512_cmpeq_epu8_mask(blocks, broadcast(smallestByte(blocks)));
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
