// Brute force for processors with AVX2.
//
// The train descriptors are stored as 64 rows of 4-bit fields, 32 descriptors a vector. A field and a query's 16-entry
// table give the number of differing bits in one byte shuffle, without xor. Tables hold two queries, one in each half
// of the byte: three fields add up to at most 12, so halves do not mix before they are split. That is 9 instructions
// for 12 bits of 32 descriptors and two queries.
#if defined(__AVX2__)
#include <immintrin.h>

#include "matching/hamming_blocked.h"

namespace gms_ransac {
namespace {

struct Avx2 {
  using Vector = __m256i;
  static constexpr int kLanes = 32;
  static constexpr int kVectors = 3;     ///< whose two sums each stay in registers; of four some did not
  static constexpr int kTileGroups = 1;  ///< a group walks over all blocks: their stream is prefetched
  static constexpr int kFields = 64;
  static constexpr int kPairs = kQueryGroup / 2;
  static constexpr int kBlockBytes = kVectors * kFields * kLanes;

  struct alignas(64) Tables {
    uint8_t count[kPairs][kFields][16];
  };

  static Vector load(const void* p) { return _mm256_load_si256(static_cast<const __m256i*>(p)); }
  static void store(void* p, Vector v) { _mm256_store_si256(static_cast<__m256i*>(p), v); }
  static Vector min(Vector a, Vector b) { return _mm256_min_epu8(a, b); }
  static Vector max(Vector a, Vector b) { return _mm256_max_epu8(a, b); }
  static Vector broadcast(int value) { return _mm256_set1_epi8(static_cast<char>(value)); }
  static int smallestByte(Vector v) {
    const __m128i half = _mm_min_epu8(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return _mm_cvtsi128_si32(_mm_minpos_epu16(_mm_min_epu8(half, _mm_srli_epi16(half, 8)))) & 255;
  }
  static Vector selectLess(Vector a, Vector b, Vector less, Vector otherwise) {
    return _mm256_blendv_epi8(less, otherwise, _mm256_cmpeq_epi8(_mm256_max_epu8(a, b), a));
  }

  /// Rows of the vectors lie side by side: [field][vector][lane].
  static void packBlock(const uint8_t* rows, int count, uint8_t* block) {
    for (int k = 0; k < count; ++k, rows += kHammingBytes) {
      uint8_t* to = block + k % kVectors * kLanes + k / kVectors;
      for (int b = 0; b < kHammingBytes; ++b, to += 2 * kVectors * kLanes) {
        to[0] = rows[b] & 15;
        to[kVectors * kLanes] = rows[b] >> 4;
      }
    }
  }

  static __m128i differences(int number) {
    const __m128i bits = _mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
    const __m128i numbers = _mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    return _mm_shuffle_epi8(bits, _mm_xor_si128(numbers, _mm_set1_epi8(static_cast<char>(number))));
  }

  static void setQueries(Tables& tables, int pair, const uint8_t* first, const uint8_t* second) {
    for (int b = 0; b < kHammingBytes; ++b) {
      auto* table = reinterpret_cast<__m128i*>(tables.count[pair][2 * b]);
      const __m128i low = _mm_slli_epi16(differences(second[b] & 15), 4);
      const __m128i high = _mm_slli_epi16(differences(second[b] >> 4), 4);
      _mm_store_si128(table, _mm_or_si128(differences(first[b] & 15), low));
      _mm_store_si128(table + 1, _mm_or_si128(differences(first[b] >> 4), high));
    }
  }

  static Vector table(const uint8_t* count) {
    return _mm256_broadcastsi128_si256(_mm_load_si128(reinterpret_cast<const __m128i*>(count)));
  }
  static Vector upperHalves(Vector v, Vector low_half) { return _mm256_and_si256(_mm256_srli_epi16(v, 4), low_half); }

  static void distances(const Tables& tables, const uint8_t* packed, int left, Vector* block_minimum) {
    constexpr int kRow = kVectors * kLanes;
    const Vector low_half = _mm256_set1_epi8(15);
#pragma GCC unroll 1
    for (int p = 0; p < kPairs; ++p) {
      Vector sum[kVectors], upper[kVectors];
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sum[v] = upper[v] = _mm256_setzero_si256();
      const uint8_t* fields = packed;
#pragma GCC unroll 3
      for (int f = 0; f < kFields - 1; f += 3, fields += 3 * kRow) {
        const Vector a = table(tables.count[p][f]);
        const Vector b = table(tables.count[p][f + 1]);
        const Vector c = table(tables.count[p][f + 2]);
#pragma GCC unroll 4
        for (int v = 0; v < kVectors; ++v) {
          Vector both = _mm256_shuffle_epi8(a, load(fields + v * kLanes));
          both = _mm256_add_epi8(both, _mm256_shuffle_epi8(b, load(fields + kRow + v * kLanes)));
          both = _mm256_add_epi8(both, _mm256_shuffle_epi8(c, load(fields + 2 * kRow + v * kLanes)));
          sum[v] = _mm256_add_epi8(sum[v], both);
          upper[v] = _mm256_add_epi8(upper[v], upperHalves(both, low_half));
        }
      }
      const Vector last = table(tables.count[p][kFields - 1]);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) {
        const Vector both = _mm256_shuffle_epi8(last, load(fields + v * kLanes));
        // sum = first query + 16 second query, modulo 256.
        Vector first = _mm256_sub_epi8(sum[v], _mm256_slli_epi16(_mm256_and_si256(upper[v], low_half), 4));
        first = _mm256_adds_epu8(first, _mm256_and_si256(both, low_half));
        Vector second = _mm256_adds_epu8(upper[v], upperHalves(both, low_half));
        if (left < kVectors * kLanes) {
          const Vector padding = paddingLanes<Avx2>(v, left);
          first = _mm256_or_si256(first, padding);
          second = _mm256_or_si256(second, padding);
        }
        block_minimum[2 * p] = v == 0 ? first : min(block_minimum[2 * p], first);
        block_minimum[2 * p + 1] = v == 0 ? second : min(block_minimum[2 * p + 1], second);
      }
    }
  }
};

inline __m256i fourDistances(__m256i query, const uint8_t* rows) {
  const __m256i low_half = _mm256_set1_epi8(15), counts = _mm256_broadcastsi128_si256(Avx2::differences(0));
  const auto words = [&](int i) {  // a sum for each word of 64 bits
    const __m256i row = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rows + i * kHammingBytes));
    const __m256i bits = _mm256_xor_si256(query, row);
    const __m256i low = _mm256_shuffle_epi8(counts, _mm256_and_si256(bits, low_half));
    const __m256i high = _mm256_shuffle_epi8(counts, Avx2::upperHalves(bits, low_half));
    return _mm256_sad_epu8(_mm256_add_epi8(low, high), _mm256_setzero_si256());
  };
  const auto addNeighbors = [](__m256i a, __m256i b) {
    return _mm256_add_epi64(_mm256_unpacklo_epi64(a, b), _mm256_unpackhi_epi64(a, b));
  };
  const __m256i first = addNeighbors(words(0), words(1)), last = addNeighbors(words(2), words(3));
  return _mm256_add_epi64(_mm256_permute2x128_si256(first, last, 0x20), _mm256_permute2x128_si256(first, last, 0x31));
}

/// Distance and index in one number each, sorted without branches.
NearestTwo searchRuns(const uint8_t* query, const uint8_t* rows, const int32_t* index, const RowRun* runs,
                      int run_count) {
  constexpr int kRows = 4, kIndexBits = 23;  // 9 bits hold a distance; the upper words of the lanes are zero
  constexpr uint32_t kLargestIndex = (1U << kIndexBits) - 1,
                     kNone = (uint32_t{kNoDistance} << kIndexBits) | kLargestIndex;
  const __m256i query_bits = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(query));
  const __m256i none = _mm256_set1_epi64x(kNone), lanes = _mm256_setr_epi64x(0, 1, 2, 3);
  __m256i best = none, second = none;
  for (int run = 0; run < run_count; ++run) {
    for (int32_t j = runs[run].first; j < runs[run].last; j += kRows) {
      const __m256i distances = fourDistances(query_bits, rows + static_cast<size_t>(j) * kHammingBytes);
      const __m256i indices = _mm256_cvtepu32_epi64(_mm_loadu_si128(reinterpret_cast<const __m128i*>(index + j)));
      const __m256i key = _mm256_or_si256(_mm256_slli_epi64(distances, kIndexBits), indices);
      const __m256i held = _mm256_cmpgt_epi32(_mm256_set1_epi32(runs[run].last - j), lanes);
      const __m256i kept = _mm256_blendv_epi8(none, key, held);
      second = _mm256_min_epu32(second, _mm256_max_epu32(best, kept));
      best = _mm256_min_epu32(best, kept);
    }
  }
  alignas(32) uint64_t keys[2 * kRows];
  Avx2::store(keys, best);
  Avx2::store(keys + kRows, second);
  uint64_t nearest = kNone, next = kNone;
  for (const uint64_t key : keys) {
    next = std::min(next, std::max(nearest, key));
    nearest = std::min(nearest, key);
  }
  return {nearest == kNone ? -1 : static_cast<int32_t>(nearest & kLargestIndex),
          static_cast<uint16_t>(nearest >> kIndexBits), static_cast<uint16_t>(next >> kIndexBits)};
}

}  // namespace

const HammingKernel kHammingKernelAvx2 = Blocked<Avx2>::kernel(searchRuns);

}  // namespace gms_ransac
#endif
