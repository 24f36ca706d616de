// Brute force pair by pair with 64-bit words: the body of the portable and of the popcount kernel, which differ only in
// the compiler flags of the file that includes it.
#pragma once

#include "matching/hamming_kernels.h"

namespace gms_ransac {
namespace {

struct OwnIndex {
  int32_t operator[](int32_t row) const { return row; }
};

void searchRowwise(const HammingSearch& search) {
  const RowRun all = {0, search.train_count};
  for (int i = 0; i < search.query_count; ++i) {
    const uint8_t* query = search.queries + static_cast<size_t>(i) * kHammingBytes;
    search.nearest[i] = searchRunsRowwise(query, search.train, OwnIndex(), &all, 1);
  }
}

size_t noBytes(int) { return 0; }
void packNothing(const uint8_t*, int, uint8_t*) {}

constexpr HammingKernel kRowwiseKernel = {noBytes, packNothing, searchRowwise, searchRunsRowwise<const int32_t*>};

}  // namespace
}  // namespace gms_ransac
