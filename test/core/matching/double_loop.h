// Drawn descriptors and their nearest neighbours by a double loop, which every matcher must find. Free of OpenCV and of
// a test framework, so that it can be cross-compiled.
#pragma once

#include <random>
#include <vector>

#include "matching/hamming_kernels.h"

namespace gms_ransac {

/// How random the bits are decides how many ties there are.
enum class Bits { kRandom, kTwoBytes, kAllEqual, kOpposite };
constexpr Bits kAllBits[] = {Bits::kRandom, Bits::kTwoBytes, Bits::kAllEqual, Bits::kOpposite};

inline std::vector<uint8_t> drawDescriptors(int n, Bits bits, uint32_t seed) {
  std::mt19937 random(seed);
  // Opposites are two complementary patterns, sometimes one bit off: distances of 0, 1, 255 and 256.
  const uint8_t pattern = bits != Bits::kOpposite ? 0x5a : seed % 2 != 0 ? 0x0f : 0xf0;
  std::vector<uint8_t> rows(static_cast<size_t>(n) * kHammingBytes, pattern);
  for (size_t first = 0; first < rows.size(); first += kHammingBytes) {
    const auto anyByte = [&]() -> uint8_t& { return rows[first + random() % kHammingBytes]; };
    for (int b = 0; bits == Bits::kRandom && b < kHammingBytes; ++b) rows[first + b] = static_cast<uint8_t>(random());
    for (int b = 0; bits == Bits::kTwoBytes && b < 2; ++b) anyByte() = static_cast<uint8_t>(random());
    if (bits == Bits::kOpposite && random() % 16 == 0) anyByte() ^= 1;
  }
  return rows;
}

/// The two nearest of each query.
inline std::vector<NearestTwo> nearestByDoubleLoop(const std::vector<uint8_t>& queries,
                                                   const std::vector<uint8_t>& train) {
  std::vector<NearestTwo> nearest(queries.size() / kHammingBytes);
  for (size_t i = 0; i < nearest.size(); ++i) {
    for (size_t j = 0; j < train.size() / kHammingBytes; ++j) {
      int distance = 0;
      for (int b = 0; b < kHammingBytes; ++b) {
        distance += __builtin_popcount(queries[i * kHammingBytes + b] ^ train[j * kHammingBytes + b]);
      }
      NearestTwo& two = nearest[i];
      if (distance < two.distance) {
        two = {static_cast<int32_t>(j), static_cast<uint16_t>(distance), two.distance};
      } else if (distance < two.second_distance) {
        two.second_distance = static_cast<uint16_t>(distance);
      }
    }
  }
  return nearest;
}

}  // namespace gms_ransac
