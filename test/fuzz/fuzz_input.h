// A fuzz target: the reader of its input, its report of a violated condition, and its entry. A target is
// one source, which includes this once and defines check().
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "support/random.h"

namespace gms_ransac {

/// Reads numbers, words and lengths from the bytes of a fuzzed input, so that most inputs mean something and small
/// changes of the bytes are small changes of the meaning. After the end everything is zero.
class FuzzInput {
 public:
  FuzzInput(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  bool empty() const { return size_ == 0; }
  size_t left() const { return size_; }

  template <typename Value>
  Value raw() {
    Value value{};
    const size_t n = std::min(size_, sizeof(value));
    if (n > 0) std::memcpy(&value, data_, n);  // an empty input may have no address
    skip(n);
    return value;
  }
  uint8_t byte() { return raw<uint8_t>(); }
  bool flag() { return byte() & 1; }

  /// In [low, high].
  int between(int low, int high) {
    const auto choices = static_cast<uint64_t>(int64_t{high} - low + 1);
    const uint64_t drawn = choices <= 256 ? byte() : choices <= 65536 ? raw<uint16_t>() : raw<uint32_t>();
    return static_cast<int>(low + static_cast<int64_t>(drawn % choices));
  }
  double within(double low, double high) { return low + (high - low) * raw<uint16_t>() / 65535; }

  template <typename Container>
  const auto& oneOf(const Container& container) {
    return container[static_cast<size_t>(between(0, static_cast<int>(container.size()) - 1))];
  }

  /// Mostly within the bounds; now and then what nobody expects.
  double number(double low, double high) {
    const uint8_t kind = byte();
    if (kind < 192) return within(low, high);
    if (kind < 208) return raw<double>();
    if (kind < 216) return raw<int32_t>();
    if (kind < 224) return low;
    if (kind < 232) return high;
    using Limits = std::numeric_limits<double>;
    static const std::array<double, 13> kOdd = {0.,
                                                -0.,
                                                1.,
                                                -1.,
                                                Limits::quiet_NaN(),
                                                Limits::infinity(),
                                                -Limits::infinity(),
                                                Limits::max(),
                                                Limits::lowest(),
                                                Limits::min(),
                                                Limits::denorm_min(),
                                                1e9,
                                                -1e-9};
    return oneOf(kOdd);
  }
  float number32(float low, float high) {
    const double value = number(low, high);
    // Out of range the conversion is undefined.
    if (std::abs(value) > std::numeric_limits<float>::max() && std::isfinite(value)) {
      return std::copysign(std::numeric_limits<float>::max(), static_cast<float>(std::copysign(1, value)));
    }
    return static_cast<float>(value);
  }

  std::string bytes(size_t most) {
    const size_t n = std::min(size_, most);
    const std::string taken(data_, data_ + n);
    skip(n);
    return taken;
  }
  std::string text(size_t most) { return bytes(std::min<size_t>(byte(), most)); }
  std::string rest() { return bytes(size_); }

  /// For what is too long to be spelt out, such as the pixels of an image.
  Random random() { return Random(raw<uint16_t>()); }

 private:
  void skip(size_t n) {
    data_ += n;
    size_ -= n;
  }

  const uint8_t* data_;
  size_t size_;
};

/// Ends the process, which is what a fuzzer takes for a find, unless `broken` is empty.
inline void demandEmpty(const std::string& broken) {
  if (broken.empty()) return;
  std::fprintf(stderr, "invariant broken: %s\n", broken.c_str());
  std::abort();
}

inline void demand(bool holds, const std::string& what) { demandEmpty(holds ? std::string() : "not so: " + what); }

/// The check that a target makes of an input.
void check(FuzzInput input);

}  // namespace gms_ransac

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  gms_ransac::check({data, size});
  return 0;
}
