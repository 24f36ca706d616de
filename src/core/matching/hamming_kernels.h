// The brute-force kernels behind HammingMatcher, one per instruction set. Free of OpenCV, so that they can be
// cross-compiled and tested alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "gms_ransac/simd.h"

namespace gms_ransac {

constexpr int kHammingBytes = 32;         ///< per descriptor
constexpr int kNoDistance = 257;          ///< larger than any distance of 256 bits
constexpr int kExactDistanceLimit = 255;  ///< kernels that count in bytes cannot tell 255 from 256

struct NearestTwo {
  int32_t index = -1;                      ///< of the nearest; the lowest on ties
  uint16_t distance = kNoDistance;         ///< exact
  uint16_t second_distance = kNoDistance;  ///< of the nearest with another index; exact
};

/// Nearest query of one train descriptor, known up to a group of consecutive queries.
struct NearestQueryGroup {
  uint16_t distance = kNoDistance;  ///< exact below kExactDistanceLimit
  int32_t first_query = -1;         ///< of the first group of HammingKernel::query_group queries that reaches it
};

/// Everything one search reads and writes. Rows are kHammingBytes apart.
struct HammingSearch {
  const uint8_t* queries = nullptr;
  int first_query = 0, last_query = 0;  ///< half-open; first_query is a multiple of query_group
  const uint8_t* train = nullptr;
  const uint8_t* packed_train = nullptr;  ///< by HammingKernel::pack, aligned to 64 bytes
  int train_count = 0;
  NearestTwo* nearest = nullptr;  ///< of each query: first_query goes to nearest[first_query]
  /// train_count entries reset by the caller; null when the reverse direction is not wanted.
  NearestQueryGroup* reverse = nullptr;
  uint8_t* scratch = nullptr;  ///< HammingKernel::scratchBytes, aligned to 64 bytes; unused without `reverse`
};

struct RowRun {
  int32_t first, last;
};
constexpr int kRowsReadPast = 7;

struct HammingKernel {
  int query_group;  ///< resolution of NearestQueryGroup::first_query
  size_t (*packedBytes)(int train_count);
  void (*pack)(const uint8_t* rows, int count, uint8_t* packed);
  size_t (*scratchBytes)(int train_count);
  void (*search)(const HammingSearch& search);
  int (*distance)(const uint8_t* a, const uint8_t* b);
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

/// HammingKernel::searchRuns with 64-bit words; inlined into every kernel's file, too.
static inline NearestTwo searchRunsRowwise(const uint8_t* query, const uint8_t* rows, const int32_t* index,
                                           const RowRun* runs, int run_count) {
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
