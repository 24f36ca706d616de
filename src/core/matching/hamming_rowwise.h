// Brute force pair by pair with 64-bit words: the body of the portable and of the popcount kernel, which differ only in
// the compiler flags of the file that includes it.
#pragma once

#include "matching/hamming_kernels.h"

namespace gms_ransac {
namespace {

template <bool kReverse>
void searchRowwise(const HammingSearch& search) {
  for (int i = search.first_query; i < search.last_query; ++i) {
    uint64_t query[4];
    std::memcpy(query, search.queries + static_cast<size_t>(i) * kHammingBytes, kHammingBytes);
    int best = kNoDistance, second = kNoDistance, index = -1;
    const uint8_t* row = search.train;
    for (int j = 0; j < search.train_count; ++j, row += kHammingBytes) {
      uint64_t train[4];
      std::memcpy(train, row, kHammingBytes);
      const int distance = __builtin_popcountll(query[0] ^ train[0]) + __builtin_popcountll(query[1] ^ train[1]) +
                           __builtin_popcountll(query[2] ^ train[2]) + __builtin_popcountll(query[3] ^ train[3]);
      if (__builtin_expect(distance < second, 0)) {
        if (distance < best) {
          second = best;
          best = distance;
          index = j;
        } else {
          second = distance;
        }
      }
      if (kReverse && __builtin_expect(distance < search.reverse[j].distance, 0)) {
        search.reverse[j].distance = static_cast<uint16_t>(distance);
        search.reverse[j].first_query = i;
      }
    }
    search.nearest[i] = {index, static_cast<uint16_t>(best), static_cast<uint16_t>(second)};
  }
}

void searchRowwise(const HammingSearch& search) {
  search.reverse ? searchRowwise<true>(search) : searchRowwise<false>(search);
}

size_t noBytes(int) { return 0; }
void packNothing(const uint8_t*, int, uint8_t*) {}
int distanceRowwise(const uint8_t* a, const uint8_t* b) { return hammingDistance(a, b); }

constexpr HammingKernel kRowwiseKernel = {
    1, noBytes, packNothing, noBytes, searchRowwise, distanceRowwise, searchRunsRowwise};

}  // namespace
}  // namespace gms_ransac
