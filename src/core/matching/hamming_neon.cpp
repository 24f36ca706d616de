// Brute force for 64-bit ARM.
//
// The train descriptors are stored as 32 rows of bytes, 16 descriptors a vector: exclusive or with the query's byte,
// count (CNT), add.
#if defined(__aarch64__)
#include <arm_neon.h>

#include "matching/hamming_blocked.h"

namespace gms_ransac {
namespace {

struct Neon {
  using Vector = uint8x16_t;
  static constexpr int kLanes = 16;
  static constexpr int kVectors = 4;
  static constexpr int kTileGroups = 1;  ///< a group walks over all blocks: their stream is prefetched
  static constexpr int kBlockBytes = kVectors * kHammingBytes * kLanes;

  struct Tables {
    uint8_t query[kQueryGroup][kHammingBytes];
  };

  static Vector load(const uint8_t* p) { return vld1q_u8(p); }
  static void store(uint8_t* p, Vector v) { vst1q_u8(p, v); }
  static Vector min(Vector a, Vector b) { return vminq_u8(a, b); }
  static Vector max(Vector a, Vector b) { return vmaxq_u8(a, b); }
  static Vector broadcast(int value) { return vdupq_n_u8(static_cast<uint8_t>(value)); }
  static int smallestByte(Vector v) { return vminvq_u8(v); }
  static Vector selectLess(Vector a, Vector b, Vector less, Vector otherwise) {
    return vbslq_u8(vcltq_u8(a, b), less, otherwise);
  }

  /// Rows of the four vectors lie side by side: [byte][vector][lane].
  static void packBlock(const uint8_t* rows, int count, uint8_t* block) {
    for (int k = 0; k < count; ++k, rows += kHammingBytes) {
      uint8_t* to = block + k % kVectors * kLanes + k / kVectors;
      for (int b = 0; b < kHammingBytes; ++b) to[b * kVectors * kLanes] = rows[b];
    }
  }

  static void setQueries(Tables& tables, int pair, const uint8_t* first, const uint8_t* second) {
    std::memcpy(tables.query[2 * pair], first, kHammingBytes);
    std::memcpy(tables.query[2 * pair + 1], second, kHammingBytes);
  }

  static void distances(const Tables& tables, const uint8_t* packed, int left, Vector* block_minimum) {
    constexpr int kRow = kVectors * kLanes;
    for (int q = 0; q < kQueryGroup; q += 2) {
      Vector first[kVectors], second[kVectors];
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) first[v] = second[v] = broadcast(0);
      for (int b = 0; b < kHammingBytes; ++b) {
        const Vector byte_first = vld1q_dup_u8(&tables.query[q][b]);
        const Vector byte_second = vld1q_dup_u8(&tables.query[q + 1][b]);
#pragma GCC unroll 4
        for (int v = 0; v < kVectors; ++v) {
          const Vector bytes = load(packed + b * kRow + v * kLanes);
          first[v] = vqaddq_u8(first[v], vcntq_u8(veorq_u8(bytes, byte_first)));
          second[v] = vqaddq_u8(second[v], vcntq_u8(veorq_u8(bytes, byte_second)));
        }
      }
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) {
        if (left < kVectors * kLanes) {
          const Vector padding = paddingLanes<Neon>(v, left);
          first[v] = vorrq_u8(first[v], padding);
          second[v] = vorrq_u8(second[v], padding);
        }
        block_minimum[q] = v == 0 ? first[v] : min(block_minimum[q], first[v]);
        block_minimum[q + 1] = v == 0 ? second[v] : min(block_minimum[q + 1], second[v]);
      }
    }
  }
};

}  // namespace

const HammingKernel kHammingKernelNeon = Blocked<Neon>::kernel();

}  // namespace gms_ransac
#endif
