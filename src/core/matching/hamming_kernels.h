// The brute-force kernels behind HammingMatcher, one per instruction set. Free of OpenCV, so that they can be
// cross-compiled and tested alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "gms_ransac/simd.h"

namespace gms_ransac {

constexpr int kHammingBytes = 32;  ///< per descriptor
constexpr int kNoDistance = 257;   ///< larger than any distance of 256 bits

struct NearestTwo {
  int32_t index = -1;                      ///< of the nearest; the lowest on ties
  uint16_t distance = kNoDistance;         ///< exact
  uint16_t second_distance = kNoDistance;  ///< of the nearest with another index; exact
};

/// Everything one search reads and writes. Rows are kHammingBytes apart.
struct HammingSearch {
  const uint8_t* queries;
  int query_count;
  const uint8_t* train;
  const uint8_t* packed_train;  ///< by HammingKernel::pack, aligned to 64 bytes
  int train_count;
  NearestTwo* nearest;  ///< of each query
};

struct RowRun {
  int32_t first, last;
};
constexpr int kRowsReadPast = 7;

struct HammingKernel {
  size_t (*packedBytes)(int train_count);
  void (*pack)(const uint8_t* rows, int count, uint8_t* packed);
  void (*search)(const HammingSearch& search);
  /// One query against runs of rows; of equal distances the lowest `index` wins. May read kRowsReadPast rows past a
  /// run.
  NearestTwo (*searchRuns)(const uint8_t* query, const uint8_t* rows, const int32_t* index, const RowRun* runs,
                           int run_count);
};

const HammingKernel& hammingKernel(SimdLevel level);

// Defined where the target has them; use hammingKernel().
extern const HammingKernel kHammingKernelPortable, kHammingKernelPopcnt, kHammingKernelAvx2, kHammingKernelAvx512,
    kHammingKernelNeon;

/// Inlined into every kernel's file, so that each counts bits with its own instructions.
static inline int hammingDistance(const uint8_t* a, const uint8_t* b) {
  int distance = 0;
  for (int i = 0; i < kHammingBytes; i += 8) {
    uint64_t x, y;
    std::memcpy(&x, a + i, 8);
    std::memcpy(&y, b + i, 8);
    distance += __builtin_popcountll(x ^ y);
  }
  return distance;
}

/// HammingKernel::searchRuns with 64-bit words; inlined into every kernel's file, too. `index`: anything that gives the
/// index of a row.
template <typename Index>
static inline NearestTwo searchRunsRowwise(const uint8_t* query, const uint8_t* rows, Index index, const RowRun* runs,
                                           int run_count) {
  int best = kNoDistance, second = kNoDistance, nearest = -1;
  for (int run = 0; run < run_count; ++run) {
    const uint8_t* row = rows + static_cast<size_t>(runs[run].first) * kHammingBytes;
    for (int32_t j = runs[run].first; j < runs[run].last; ++j, row += kHammingBytes) {
      const int distance = hammingDistance(query, row);
      if (__builtin_expect(distance > second, 1)) continue;
      if (distance < best || (distance == best && index[j] < nearest)) {
        second = best;
        best = distance;
        nearest = index[j];
      } else {
        second = distance;
      }
    }
  }
  return {nearest, static_cast<uint16_t>(best), static_cast<uint16_t>(second)};
}

}  // namespace gms_ransac
