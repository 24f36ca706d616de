// Compares every matching kernel that this processor can run with a double loop. Free of OpenCV and of a test
// framework, so that it can be cross-compiled; prints what it compared and exits with 1 at the first difference.
#include <algorithm>
#include <cstdio>

#include "double_loop.h"

namespace {

using namespace gms_ransac;  // NOLINT: one program, one file

struct alignas(64) Line {
  uint8_t bytes[64];
};

bool same(const NearestTwo& a, const NearestTwo& b) {
  return a.index == b.index && a.distance == b.distance && a.second_distance == b.second_distance;
}

bool check(const HammingKernel& kernel, int queries, int train_count, Bits bits) {
  const std::vector<uint8_t> query = drawDescriptors(queries, bits, 11), train = drawDescriptors(train_count, bits, 12);
  std::vector<Line> packed(kernel.packedBytes(train_count) / 64 + 1);
  kernel.pack(train.data(), train_count, packed[0].bytes);
  std::vector<NearestTwo> nearest(queries);
  kernel.search({query.data(), queries, train.data(), packed[0].bytes, train_count, nearest.data()});
  return std::equal(nearest.begin(), nearest.end(), nearestByDoubleLoop(query, train).begin(), same);
}

/// Runs of any length, the rows in the opposite order of their indices.
bool checkRuns(const HammingKernel& kernel, int rows, Bits bits) {
  std::mt19937 random(11);
  const std::vector<uint8_t> query = drawDescriptors(1, bits, 11),
                             train = drawDescriptors(rows + kRowsReadPast, bits, 12);
  std::vector<int32_t> index(static_cast<size_t>(rows) + kRowsReadPast);
  for (int j = 0; j < rows; ++j) index[j] = rows - 1 - j;
  std::vector<RowRun> runs;
  for (int32_t first = 0; first < rows; first = runs.back().last + static_cast<int32_t>(random() % 5)) {
    const int32_t length = random() % 4 == 0 ? 300 : static_cast<int32_t>(random() % 20);
    runs.push_back({first, std::min(first + length, rows)});
  }
  // The rows of the runs by rising index, so that the lowest of equals is the first.
  std::vector<uint8_t> held;
  std::vector<int32_t> held_index;
  for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
    for (int row = run->last - 1; row >= run->first; --row) {
      held.insert(held.end(), &train[row * kHammingBytes], &train[row * kHammingBytes] + kHammingBytes);
      held_index.push_back(index[row]);
    }
  }
  NearestTwo expected = nearestByDoubleLoop(query, held)[0];
  if (expected.index >= 0) expected.index = held_index[expected.index];
  return same(expected,
              kernel.searchRuns(query.data(), train.data(), index.data(), runs.data(), static_cast<int>(runs.size())));
}

constexpr int kRuns = -1;  // in place of a number of queries

bool checkKernel(const char* name, const HammingKernel& kernel) {
  int cases = 0;
  const auto equals = [&](int queries, int rows, Bits bits) {
    const bool equal = queries == kRuns ? checkRuns(kernel, rows, bits) : check(kernel, queries, rows, bits);
    if (!equal) std::printf("%s differs: %d x %d, bits %d\n", name, queries, rows, static_cast<int>(bits));
    ++cases;
    return equal;
  };
  bool ok = true;
  for (const Bits bits : kAllBits) {
    for (int queries : {0, 1, 7, 33, 300}) {
      for (int train_count : {1, 7, 33, 64, 257, 600}) ok = ok && equals(queries, train_count, bits);
    }
    for (int rows : {0, 1, 2, 9, 100, 1000}) ok = ok && equals(kRuns, rows, bits);
  }
  // Beyond one run.
  ok = ok && equals(4097, 40, Bits::kTwoBytes) && equals(3, 17000, Bits::kTwoBytes);
  if (ok) std::printf("%s equals the double loop in %d cases\n", name, cases);
  return ok;
}

}  // namespace

int main() {
  bool ok = checkKernel("portable", kHammingKernelPortable);
  for (SimdLevel level : {SimdLevel::kScalar, SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (simdLevelSupported(level)) ok = checkKernel(toString(level).c_str(), hammingKernel(level)) && ok;
  }
  return ok ? 0 : 1;
}
