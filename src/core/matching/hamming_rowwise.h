// Brute force pair by pair with 64-bit words: the body of the portable and of the popcount kernel, which differ only in
// the compiler flags of the file that includes it.
#pragma once

#include "matching/hamming_kernels.h"

namespace gms_ransac {
namespace {

template <bool kReverse>
void searchRowwise(const HammingSearch& search) {
  for (int i = search.first_query; i < search.last_query; ++i) {
    const uint8_t* query = search.queries + static_cast<size_t>(i) * kHammingBytes;
    int best = kNoDistance, second = kNoDistance, index = -1;
    const uint8_t* row = search.train;
    for (int j = 0; j < search.train_count; ++j, row += kHammingBytes) {
      const int distance = hammingDistance(query, row);
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

constexpr HammingKernel kRowwiseKernel = {
    1, noBytes, packNothing, noBytes, searchRowwise, hammingDistance, searchRunsRowwise};

}  // namespace
}  // namespace gms_ransac
