// Brute force for processors with AVX-512 VBMI, GFNI and VPOPCNTDQ (Ice Lake, Zen 4 and later).
//
// 512 train descriptors at a time, bit-sliced: a vector holds one bit of each. Bits are counted by carry-save adders,
// two three-input logic instructions each. The first layer of adders costs nothing: three bits of a query have eight
// patterns, so the sum and carry of every triple of train bits are stored for all eight. A query picks by its own
// bits. 170 adders remain: 340 instructions for 512 descriptors, where counting by table lookups in bytes takes 560.
#if defined(__AVX512VBMI__)
#include <immintrin.h>

// GCC 12's own AVX-512 headers read undefined vectors on purpose and are warned about where they are inlined.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"

#include "matching/hamming_blocked.h"

namespace gms_ransac {
namespace {

constexpr int kTriples = 85;  ///< of bits, and one single bit
constexpr int kPatterns = 8;
constexpr int kVectorBytes = 64;
/// A triple is stored as its sum bit and the sum's complement, then its carry for every pattern of query bits.
constexpr int kTripleBytes = (2 + kPatterns) * kVectorBytes;
constexpr int kSingleOffset = kTriples * kTripleBytes;

struct alignas(64) TripleOffsets {
  uint16_t first[96] = {};
  constexpr TripleOffsets() {
    for (int i = 0; i < kTriples; ++i) first[i] = static_cast<uint16_t>(i * kTripleBytes);
  }
};
constexpr TripleOffsets kTripleOffsets;

inline __m512i sumBit(__m512i a, __m512i b, __m512i c) { return _mm512_ternarylogic_epi64(a, b, c, 0x96); }
inline __m512i carryBit(__m512i a, __m512i b, __m512i c) { return _mm512_ternarylogic_epi64(a, b, c, 0xe8); }

inline __m512i add(__m512i& sum, __m512i a, __m512i b) {
  const __m512i carry = carryBit(sum, a, b);
  sum = sumBit(sum, a, b);
  return carry;
}

/// Sum and carry bits of one query against a block, triple by triple.
struct Triples {
  const uint8_t* packed;
  const uint16_t* sum_offset;
  const uint16_t* carry_offset;

  __m512i sum(int i) const { return _mm512_load_si512(packed + sum_offset[i]); }
  __m512i carry(int i) const { return _mm512_load_si512(packed + carry_offset[i]); }
};

struct Carries {
  __m512i a, b, c;
};

/// Adds 4 * 2^kLevel triples to the bit planes; returns the carries to plane kLevel + 2.
template <int kLevel>
inline Carries addTriples(const Triples& triples, int first, __m512i* planes) {
  if constexpr (kLevel == 0) {
    const __m512i ones = add(planes[0], triples.sum(first), triples.sum(first + 1));
    const __m512i a = add(planes[1], triples.carry(first), triples.carry(first + 1));
    const __m512i more_ones = add(planes[0], triples.sum(first + 2), triples.sum(first + 3));
    const __m512i b = add(planes[1], triples.carry(first + 2), triples.carry(first + 3));
    return {a, b, add(planes[1], ones, more_ones)};
  } else {
    const Carries x = addTriples<kLevel - 1>(triples, first, planes);
    const __m512i a = add(planes[kLevel + 1], x.a, x.b);
    const Carries y = addTriples<kLevel - 1>(triples, first + (4 << (kLevel - 1)), planes);
    const __m512i b = add(planes[kLevel + 1], y.a, y.b);
    return {a, b, add(planes[kLevel + 1], x.c, y.c)};
  }
}

struct Avx512 {
  using Vector = __m512i;
  static constexpr int kLanes = 64;
  static constexpr int kVectors = 8;
  static constexpr int kBlockBytes = kSingleOffset + 2 * kVectorBytes;
  /// A block comes from the second-level cache once a tile; 16 groups measured best of 4 to 64 at 10000 descriptors.
  static constexpr int kTileGroups = 16;

  struct alignas(64) Tables {
    uint16_t sum[kQueryGroup][96];
    uint16_t carry[kQueryGroup][96];
    uint16_t single[kQueryGroup];
  };

  static Vector load(const void* p) { return _mm512_load_si512(p); }
  static void store(void* p, Vector v) { _mm512_store_si512(p, v); }
  static Vector min(Vector a, Vector b) { return _mm512_min_epu8(a, b); }
  static Vector max(Vector a, Vector b) { return _mm512_max_epu8(a, b); }
  static Vector broadcast(int value) { return _mm512_set1_epi8(static_cast<char>(value)); }
  static int smallestByte(Vector v) {
    const __m256i half = _mm256_min_epu8(_mm512_castsi512_si256(v), _mm512_extracti64x4_epi64(v, 1));
    const __m128i quarter = _mm_min_epu8(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1));
    return _mm_cvtsi128_si32(_mm_minpos_epu16(_mm_min_epu8(quarter, _mm_srli_epi16(quarter, 8)))) & 255;
  }
  static Vector selectLess(Vector a, Vector b, Vector less, Vector otherwise) {
    return _mm512_mask_mov_epi8(otherwise, _mm512_cmplt_epu8_mask(a, b), less);
  }

  /// Bit of a plane for train descriptor `i`, which spread() puts in lane i / kVectors of vector i % kVectors.
  static int bitOf(int i) {
    const int vector = i % kVectors, lane = i / kVectors;
    return lane / 16 * 128 + vector * 16 + lane % 16;
  }

  static void packBlock(const uint8_t* rows, int count, uint8_t* block) {
    alignas(64) uint64_t planes[8 * kHammingBytes][kVectorBytes / 8];
    slice(rows, count, planes);
    for (int i = 0; i < kTriples; ++i) {
      const Vector a = load(planes[3 * i]), b = load(planes[3 * i + 1]), c = load(planes[3 * i + 2]);
      const Vector all = _mm512_set1_epi8(-1);
      const Vector sum = sumBit(a, b, c);
      uint8_t* to = block + i * kTripleBytes;
      store(to, sum);
      store(to + kVectorBytes, _mm512_xor_si512(sum, all));
      for (int pattern = 0; pattern < kPatterns; ++pattern) {
        const auto differs = [&](Vector bit, int k) { return pattern >> k & 1 ? _mm512_xor_si512(bit, all) : bit; };
        store(to + (2 + pattern) * kVectorBytes, carryBit(differs(a, 0), differs(b, 1), differs(c, 2)));
      }
    }
    const Vector last = load(planes[3 * kTriples]);
    store(block + kSingleOffset, last);
    store(block + kSingleOffset + kVectorBytes, _mm512_xor_si512(last, _mm512_set1_epi8(-1)));
  }

  /// Bit planes of a block: bit b of byte k of every descriptor in planes[8 k + b], see bitOf.
  static void slice(const uint8_t* rows, int count, uint64_t (*planes)[kVectorBytes / 8]) {
    // Byte k of 16 dwords next to each other.
    const Vector by_byte = _mm512_set_epi32(0x3f3b3733, 0x2f2b2723, 0x1f1b1713, 0x0f0b0703, 0x3e3a3632, 0x2e2a2622,
                                            0x1e1a1612, 0x0e0a0602, 0x3d393531, 0x2d292521, 0x1d191511, 0x0d090501,
                                            0x3c383430, 0x2c282420, 0x1c181410, 0x0c080400);
    alignas(64) int32_t place[kLanes * kVectors];
    for (int i = 0; i < kLanes * kVectors; ++i) place[bitOf(i)] = std::min(i, count - 1) * kHammingBytes;
    for (int word = 0; word < kVectorBytes / 8; ++word) {
      for (int dword = 0; dword < kHammingBytes; dword += 4) {
        alignas(64) uint8_t bytes[4][kLanes];
        for (int part = 0; part < 4; ++part) {
          const Vector from = load(place + 64 * word + 16 * part);
          const Vector sorted = _mm512_permutexvar_epi8(by_byte, _mm512_i32gather_epi32(from, rows + dword, 1));
          const auto put = [&](int k, __m128i quarter) {
            _mm_store_si128(reinterpret_cast<__m128i*>(bytes[k] + 16 * part), quarter);
          };
          put(0, _mm512_extracti32x4_epi32(sorted, 0));
          put(1, _mm512_extracti32x4_epi32(sorted, 1));
          put(2, _mm512_extracti32x4_epi32(sorted, 2));
          put(3, _mm512_extracti32x4_epi32(sorted, 3));
        }
        for (int k = 0; k < 4; ++k) {
          const Vector byte = load(bytes[k]);
          for (int bit = 0; bit < 8; ++bit) {
            planes[8 * (dword + k) + bit][word] = _mm512_test_epi8_mask(byte, broadcast(1 << bit));
          }
        }
      }
    }
  }

  static void setQueries(Tables& tables, int pair, const uint8_t* first, const uint8_t* second) {
    setQuery(tables, 2 * pair, first);
    setQuery(tables, 2 * pair + 1, second);
  }

  /// Where the sums and carries of a query's triples lie in a block.
  static void setQuery(Tables& tables, int q, const uint8_t* row) {
    // Eight triples are three bytes: those go to one 64-bit word, from which they are picked at every third bit.
    alignas(64) static constexpr uint8_t kThreeBytes[64] = {
        0,  1,  2,  0, 0, 0, 0, 0, 3,  4,  5,  0, 0, 0, 0, 0, 6,  7,  8,  0, 0, 0, 0, 0, 9,  10, 11, 0, 0, 0, 0, 0,
        12, 13, 14, 0, 0, 0, 0, 0, 15, 16, 17, 0, 0, 0, 0, 0, 18, 19, 20, 0, 0, 0, 0, 0, 21, 22, 23, 0, 0, 0, 0, 0};
    constexpr int kBytesInTheFirst = 24;
    constexpr uint64_t kEveryThirdBit = 0x15120f0c09060300;
    const auto patterns = [&](int first_byte) {
      const Vector bytes = _mm512_maskz_loadu_epi8(~0U >> first_byte, row + first_byte);  // the rest of the 32
      const Vector words = _mm512_permutexvar_epi8(load(kThreeBytes), bytes);
      const Vector picked = _mm512_multishift_epi64_epi8(_mm512_set1_epi64(kEveryThirdBit), words);
      return _mm512_and_si512(picked, broadcast(kPatterns - 1));
    };
    const Vector odd_parity = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 1, 1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0));
    const Vector low = patterns(0), high = patterns(kBytesInTheFirst);
    const __m256i parts[3] = {_mm512_castsi512_si256(low), _mm512_extracti64x4_epi64(low, 1),
                              _mm512_castsi512_si256(high)};
    for (int i = 0; i < 3; ++i) {
      const Vector triple = load(kTripleOffsets.first + 32 * i);
      const Vector pattern = _mm512_cvtepu8_epi16(parts[i]);
      const Vector parity = _mm512_cvtepu8_epi16(_mm256_shuffle_epi8(_mm512_castsi512_si256(odd_parity), parts[i]));
      const Vector carries = _mm512_set1_epi16(2 * kVectorBytes);
      store(tables.sum[q] + 32 * i, _mm512_add_epi16(triple, _mm512_slli_epi16(parity, 6)));
      store(tables.carry[q] + 32 * i,
            _mm512_add_epi16(_mm512_add_epi16(triple, carries), _mm512_slli_epi16(pattern, 6)));
    }
    tables.single[q] = static_cast<uint16_t>(kSingleOffset + (row[kHammingBytes - 1] >> 7) * kVectorBytes);
  }

  /// Bit planes of the distances of one query, 255 for 256 and where `padding` is set.
  static void count(const Tables& tables, int q, const uint8_t* packed, Vector padding, Vector* planes) {
    const Triples triples{packed, tables.sum[q], tables.carry[q]};
    // 84 triples as 64 + 16 + 4, each part beginning where it need not be added to planes still empty.
    planes[0] = load(packed + tables.single[q]);
    planes[1] = planes[2] = planes[3] = planes[4] = planes[5] = _mm512_setzero_si512();
    const Carries c64 = addTriples<4>(triples, 0, planes);
    const Carries c16 = addTriples<2>(triples, 64, planes);
    const Carries c4 = addTriples<0>(triples, 80, planes);
    const __m512i no = _mm512_setzero_si512();
    const __m512i to1 = add(planes[0], triples.sum(84), no);
    const __m512i to2 = add(planes[1], triples.carry(84), to1);
    const __m512i a3 = add(planes[2], c4.a, c4.b), b3 = add(planes[2], c4.c, to2);
    const __m512i a4 = add(planes[3], a3, b3);
    const __m512i a5 = add(planes[4], c16.a, c16.b), b5 = add(planes[4], c16.c, a4);
    const __m512i a6 = add(planes[5], a5, b5);
    planes[6] = c64.a;
    const __m512i a7 = add(planes[6], c64.b, c64.c);
    const __m512i b7 = _mm512_and_si512(planes[6], a6);
    planes[6] = _mm512_xor_si512(planes[6], a6);
    planes[7] = _mm512_xor_si512(a7, b7);
    const __m512i full = _mm512_or_si512(_mm512_and_si512(a7, b7), padding);
    if (_mm512_test_epi64_mask(full, full)) {
      for (int i = 0; i < 8; ++i) planes[i] = _mm512_or_si512(planes[i], full);
    }
  }

  static void spread(const Vector* planes, Vector* bytes) {
    // Bytes of the planes side by side, the highest first: eight by eight bits, which one instruction transposes.
    Vector pairs[2][4], fours[4][2];
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      pairs[0][i] = _mm512_unpacklo_epi8(planes[7 - 2 * i], planes[6 - 2 * i]);
      pairs[1][i] = _mm512_unpackhi_epi8(planes[7 - 2 * i], planes[6 - 2 * i]);
    }
#pragma GCC unroll 4
    for (int i = 0; i < 2; ++i) {
#pragma GCC unroll 4
      for (int half = 0; half < 2; ++half) {
        fours[2 * half][i] = _mm512_unpacklo_epi16(pairs[half][2 * i], pairs[half][2 * i + 1]);
        fours[2 * half + 1][i] = _mm512_unpackhi_epi16(pairs[half][2 * i], pairs[half][2 * i + 1]);
      }
    }
    const Vector unit = _mm512_set1_epi64(static_cast<int64_t>(0x8040201008040201));
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      bytes[2 * i] = _mm512_gf2p8affine_epi64_epi8(unit, _mm512_unpacklo_epi32(fours[i][0], fours[i][1]), 0);
      bytes[2 * i + 1] = _mm512_gf2p8affine_epi64_epi8(unit, _mm512_unpackhi_epi32(fours[i][0], fours[i][1]), 0);
    }
  }

  static void distances(const Tables& tables, const uint8_t* packed, int left, Vector* block_minimum) {
    const Vector padding = left >= kVectors * kLanes ? _mm512_setzero_si512() : paddingPlane(left);
#pragma GCC unroll 1
    for (int q = 0; q < kQueryGroup; ++q) {
      Vector planes[8], bytes[kVectors];
      count(tables, q, packed, padding, planes);
      spread(planes, bytes);
      const Vector a = min(min(bytes[0], bytes[1]), min(bytes[2], bytes[3]));
      const Vector b = min(min(bytes[4], bytes[5]), min(bytes[6], bytes[7]));
      block_minimum[q] = min(a, b);
    }
  }

  static Vector paddingPlane(int left) {
    alignas(64) uint64_t plane[kVectorBytes / 8] = {};
    for (int i = left; i < kVectors * kLanes; ++i) plane[bitOf(i) / 64] |= uint64_t{1} << bitOf(i) % 64;
    return load(plane);
  }
};

inline __m512i eightDistances(__m512i query, const uint8_t* rows) {
  const auto pair = [&](int i) {
    return _mm512_popcnt_epi64(_mm512_xor_si512(query, _mm512_loadu_si512(rows + i * kVectorBytes)));
  };
  const auto addNeighbors = [](__m512i a, __m512i b) {
    return _mm512_add_epi64(_mm512_unpacklo_epi64(a, b), _mm512_unpackhi_epi64(a, b));
  };
  const __m512i low = addNeighbors(pair(0), pair(1)), high = addNeighbors(pair(2), pair(3));
  const __m512i sums = _mm512_add_epi64(_mm512_shuffle_i64x2(low, high, 0x88), _mm512_shuffle_i64x2(low, high, 0xdd));
  const __m512i place_of_row = _mm512_setr_epi64(0, 2, 1, 3, 4, 6, 5, 7);
  return _mm512_permutexvar_epi64(place_of_row, sums);
}

/// Distance and index in one number each, sorted without branches.
NearestTwo searchRuns(const uint8_t* query, const uint8_t* rows, const int32_t* index, const RowRun* runs,
                      int run_count) {
  constexpr int kRows = kRowsReadPast + 1, kIndexBits = 32;
  const __m512i none = _mm512_set1_epi64((static_cast<int64_t>(kNoDistance) << kIndexBits) | UINT32_MAX);
  const __m512i both = _mm512_broadcast_i64x4(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(query)));
  __m512i best = none, second = none;
  for (int run = 0; run < run_count; ++run) {
    for (int32_t j = runs[run].first; j < runs[run].last; j += kRows) {
      const auto held = static_cast<__mmask8>((1 << std::min(runs[run].last - j, kRows)) - 1);
      const __m512i distances = eightDistances(both, rows + static_cast<size_t>(j) * kHammingBytes);
      const __m256i indices = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index + j));
      const __m512i key =
          _mm512_mask_or_epi64(none, held, _mm512_slli_epi64(distances, kIndexBits), _mm512_cvtepu32_epi64(indices));
      second = _mm512_min_epu64(second, _mm512_max_epu64(best, key));
      best = _mm512_min_epu64(best, key);
    }
  }
  const uint64_t nearest = _mm512_reduce_min_epu64(best);
  const __mmask8 others = _mm512_cmpneq_epu64_mask(best, _mm512_set1_epi64(static_cast<int64_t>(nearest)));
  const uint64_t next = _mm512_reduce_min_epu64(_mm512_min_epu64(second, _mm512_mask_mov_epi64(none, others, best)));
  return {static_cast<int32_t>(nearest), static_cast<uint16_t>(nearest >> kIndexBits),
          static_cast<uint16_t>(next >> kIndexBits)};
}

}  // namespace

const HammingKernel kHammingKernelAvx512 = Blocked<Avx512>::kernel(searchRuns);

}  // namespace gms_ransac
#endif
