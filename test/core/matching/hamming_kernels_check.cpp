// Compares every matching kernel that this processor can run with a double loop. Free of OpenCV and of a test
// framework, so that it can be cross-compiled; prints what it compared and exits with 1 at the first difference.
#include <algorithm>
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

/// Runs of any length, the rows in another order than their indices.
bool checkRuns(const HammingKernel& kernel, int rows, int bits, std::mt19937& random) {
  const std::vector<uint8_t> query = descriptors(1, bits, true, random);
  const std::vector<uint8_t> train = descriptors(rows + kRowsReadPast, bits, false, random);
  std::vector<int32_t> index(static_cast<size_t>(rows) + kRowsReadPast);
  for (int j = 0; j < rows; ++j) index[j] = rows - 1 - j;
  std::vector<RowRun> runs;
  for (int32_t first = 0; first < rows; first = runs.back().last + static_cast<int32_t>(random() % 5)) {
    const int32_t length = random() % 4 == 0 ? 300 : static_cast<int32_t>(random() % 20);
    runs.push_back({first, std::min(first + length, rows)});
  }
  NearestTwo expected;
  for (int i = 0; i < rows; ++i) {  // by index, so that the lowest of equals is the first
    const int row = rows - 1 - i;
    const auto held = [&](const RowRun& run) { return run.first <= row && row < run.last; };
    if (std::none_of(runs.begin(), runs.end(), held)) continue;
    int distance = 0;
    for (int b = 0; b < kHammingBytes; ++b) {
      distance += __builtin_popcount(query[b] ^ train[static_cast<size_t>(row) * kHammingBytes + b]);
    }
    if (distance < expected.distance) {
      expected.second_distance = expected.distance;
      expected.distance = static_cast<uint16_t>(distance);
      expected.index = i;
    } else if (distance < expected.second_distance) {
      expected.second_distance = static_cast<uint16_t>(distance);
    }
  }
  const NearestTwo found =
      kernel.searchRuns(query.data(), train.data(), index.data(), runs.data(), static_cast<int>(runs.size()));
  return found.index == expected.index && found.distance == expected.distance &&
         found.second_distance == expected.second_distance;
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
  for (int bits = 0; bits < 4; ++bits) {
    for (int rows : {0, 1, 2, 9, 100, 1000}) {
      if (!checkRuns(kernel, rows, bits, random)) {
        std::printf("%s differs from the double loop over runs of %d rows, bits %d\n", name, rows, bits);
        return false;
      }
      ++cases;
    }
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
