// The n-th smallest of many values, faster than std::nth_element, whose comparisons cannot be predicted.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace gms_ransac {

namespace detail {

constexpr int kOrderBits = 11;  ///< sign, exponent and the first two bits of the mantissa

inline uint32_t orderKey(float value) {
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  constexpr uint32_t kSign = 0x80000000;
  const uint32_t rising = (bits & kSign) != 0 ? ~bits : bits | kSign;
  return rising >> (32 - kOrderBits);
}

}  // namespace detail

/// The values that would stand at these places, in ascending order and below the size, if all were sorted; NaN is no
/// value. Rearranges them.
template <size_t N>
std::array<float, N> smallest(std::vector<float>& values, const std::array<size_t, N>& places) {
  std::array<uint32_t, 1 << detail::kOrderBits> count{};
  for (const float value : values) ++count[detail::orderKey(value)];
  std::array<float, N> result;
  uint32_t key = 0;
  size_t below = 0;
  for (size_t k = 0; k < N; ++k) {
    while (places[k] - below >= count[key]) below += count[key++];
    auto end = values.begin();
    for (float& value : values) {
      if (detail::orderKey(value) == key) std::swap(value, *end++);
    }
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(places[k] - below);
    std::nth_element(values.begin(), place, end);
    result[k] = *place;
  }
  return result;
}

inline float nthSmallest(std::vector<float>& values, size_t n) { return smallest<1>(values, {n})[0]; }

}  // namespace gms_ransac
