// Compares every matching kernel that this processor can run with a double loop. Free of OpenCV and of a test
// framework, so that it can be cross-compiled; prints what it compared and exits with 1 at the first difference.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include "matching/hamming_kernels.h"

namespace {

using namespace gms_ransac;  // NOLINT: one program, one file

struct AlignedBuffer {
  explicit AlignedBuffer(size_t bytes)
      : data(static_cast<uint8_t*>(std::aligned_alloc(64, (bytes + 127) / 64 * 64)), std::free) {}
  std::unique_ptr<uint8_t, void (*)(void*)> data;
};

/// `bits` decides how many ties there are: 0 random, 1 few bits set, 2 all equal, 3 all opposite.
std::vector<uint8_t> descriptors(int n, int bits, bool queries, std::mt19937& random) {
  std::vector<uint8_t> rows(static_cast<size_t>(n) * kHammingBytes, bits == 3 && queries ? 255 : 0);
  if (bits == 0) {
    for (uint8_t& byte : rows) byte = static_cast<uint8_t>(random());
  } else if (bits == 1) {
    for (int i = 0; i < n; ++i)
      rows[static_cast<size_t>(i) * kHammingBytes + random() % kHammingBytes] = random() % 256;
  }
  return rows;
}

bool check(const HammingKernel& kernel, int queries, int train_count, int bits, std::mt19937& random) {
  const std::vector<uint8_t> query = descriptors(queries, bits, true, random);
  const std::vector<uint8_t> train = descriptors(train_count, bits, false, random);
  const AlignedBuffer packed(kernel.packedBytes(train_count)), scratch(kernel.scratchBytes(train_count));
  kernel.pack(train.data(), train_count, packed.data.get());

  std::vector<NearestTwo> nearest(queries);
  std::vector<NearestQueryGroup> reverse(train_count);
  HammingSearch search;
  search.queries = query.data();
  search.last_query = queries;
  search.train = train.data();
  search.packed_train = packed.data.get();
  search.train_count = train_count;
  search.nearest = nearest.data();
  search.reverse = reverse.data();
  search.scratch = scratch.data.get();
  kernel.search(search);

  std::vector<int> reverse_distance(train_count, kNoDistance), reverse_query(train_count, -1);
  for (int i = 0; i < queries; ++i) {
    int best = kNoDistance, second = kNoDistance, index = -1;
    for (int j = 0; j < train_count; ++j) {
      int distance = 0;
      for (int b = 0; b < kHammingBytes; ++b) {
        distance += __builtin_popcount(query[i * kHammingBytes + b] ^ train[j * kHammingBytes + b]);
      }
      if (distance < best) {
        second = best;
        best = distance;
        index = j;
      } else if (distance < second) {
        second = distance;
      }
      if (distance < reverse_distance[j]) {
        reverse_distance[j] = distance;
        reverse_query[j] = i;
      }
    }
    if (nearest[i].distance != best || nearest[i].second_distance != second || nearest[i].index != index) return false;
  }
  for (int j = 0; j < train_count && queries > 0; ++j) {
    if (reverse_distance[j] >= kExactDistanceLimit) continue;  // the kernel does not claim these
    const int first = reverse[j].first_query;
    if (reverse[j].distance != reverse_distance[j]) return false;
    if (reverse_query[j] < first || reverse_query[j] >= first + kernel.query_group) return false;
  }
  return true;
}

bool checkKernel(const char* name, const HammingKernel& kernel) {
  std::mt19937 random(11);
  int cases = 0;
  for (int bits = 0; bits < 4; ++bits) {
    for (int queries : {0, 1, 7, 33, 300}) {
      for (int train_count : {1, 7, 33, 64, 257, 600}) {
        if (!check(kernel, queries, train_count, bits, random)) {
          std::printf("%s differs from the double loop: %d x %d, bits %d\n", name, queries, train_count, bits);
          return false;
        }
        ++cases;
      }
    }
  }
  if (!check(kernel, 4097, 40, 1, random) || !check(kernel, 3, 17000, 1, random)) {
    std::printf("%s differs from the double loop beyond one run\n", name);
    return false;
  }
  std::printf("%s equals the double loop in %d cases\n", name, cases + 2);
  return true;
}

}  // namespace

int main() {
  bool ok = checkKernel("portable", kHammingKernelPortable);
  for (SimdLevel level : {SimdLevel::kScalar, SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (simdLevelSupported(level)) ok = checkKernel(toString(level).c_str(), hammingKernel(level)) && ok;
  }
  return ok ? 0 : 1;
}
