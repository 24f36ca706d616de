// The inner loops of the alignment of patches over the compiler's own vectors. Included once by the file of each
// instruction set, which defines GMS_RANSAC_VECTOR_BYTES before; everything lies in an unnamed namespace so that no two
// sets share a function.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "matching/patch_kernels.h"
#include "matching/row_sums_impl.h"

namespace gms_ransac {
namespace {

constexpr int kLanes = GMS_RANSAC_VECTOR_BYTES / 4;
constexpr int kRimSide = kPatchSide + 2;                    ///< of a patch with the pixels around it
constexpr int kVectors = (kRimSide + kLanes - 1) / kLanes;  ///< of a row
using F32 [[gnu::vector_size(GMS_RANSAC_VECTOR_BYTES)]] = float;
using I32 [[gnu::vector_size(GMS_RANSAC_VECTOR_BYTES)]] = int32_t;
using Bytes [[gnu::vector_size(kLanes)]] = uint8_t;
using FourFloats [[gnu::vector_size(16)]] = float;

template <typename Vector>
inline Vector load(const void* p) {
  Vector a;
  std::memcpy(&a, p, sizeof a);
  return a;
}

inline F32 loadFloats(const float* row, int vector) { return load<F32>(row + vector * kLanes); }
inline void store(float* row, int vector, F32 a) { std::memcpy(row + vector * kLanes, &a, sizeof a); }
/// Number by number, of which GCC makes one instruction, unlike of a conversion of the vector.
template <int... i>
inline F32 toFloats(const Bytes& bytes, std::integer_sequence<int, i...>) {
  return __builtin_convertvector(I32{bytes[i]...}, F32);
}
inline F32 loadBytes(const uint8_t* p) { return toFloats(load<Bytes>(p), std::make_integer_sequence<int, kLanes>()); }
inline F32 all(float a) { return a - F32{}; }

/// Offsets of the columns from the centre, and 1 in each; past the last one its offset, and 0.
template <int kSide>
struct Columns {
  static constexpr int kHalf = kSide / 2;
  float offset[kPatchLanes] = {}, inside[kPatchLanes] = {};

  constexpr Columns() {
    for (int i = 0; i < kPatchLanes; ++i) {
      offset[i] = static_cast<float>(std::min(i, kSide - 1) - kHalf);
      inside[i] = i < kSide ? 1 : 0;
    }
  }
};

/// Adds up a patch in an order that does not depend on the width of the vectors.
inline float sum(const F32 (&lanes)[kVectors]) {
  float numbers[kPatchLanes] = {};
  for (int k = 0; k < kVectors; ++k) store(numbers, k, lanes[k]);
  const FourFloats four = (load<FourFloats>(numbers) + load<FourFloats>(numbers + 8)) +
                          (load<FourFloats>(numbers + 4) + load<FourFloats>(numbers + 12));
  return (four[0] + four[2]) + (four[1] + four[3]);
}

/// Where shape is the identity, all pixels lie at the same fractions of one.
template <int kSide>
void sampleUpright(const uint8_t* image, ptrdiff_t stride, const PatchMap& place, float (*levels)[kPatchLanes]) {
  static constexpr Columns<kSide> columns;
  const auto left = static_cast<int>(place.x), top = static_cast<int>(place.y);
  const F32 u = all(place.x - static_cast<float>(left)), v = all(place.y - static_cast<float>(top));
  uint8_t pixels[kSide + 1][2 * kPatchLanes];
  const uint8_t* first = image + (top - columns.kHalf) * stride + left - columns.kHalf;
  for (int row = 0; row <= kSide; ++row) {
    std::memset(pixels[row], 0, sizeof pixels[row]);
    std::memcpy(pixels[row], first + row * stride, kSide + 1);
  }
  F32 above[kVectors];
  for (int row = 0; row <= kSide; ++row) {
    for (int k = 0; k < kVectors; ++k) {
      const F32 a = loadBytes(pixels[row] + k * kLanes), b = loadBytes(pixels[row] + k * kLanes + 1);
      const F32 here = a + u * (b - a);
      if (row > 0) store(levels[row - 1], k, (above[k] + v * (here - above[k])) * loadFloats(columns.inside, k));
      above[k] = here;
    }
  }
}

template <int kSide>
void sampleWarped(const uint8_t* image, ptrdiff_t stride, const PatchMap& place, float (*levels)[kPatchLanes]) {
  static constexpr Columns<kSide> columns;
  int32_t offsets[kSide][kPatchLanes];
  float u[kSide][kPatchLanes], v[kSide][kPatchLanes];
  for (int row = 0; row < kSide; ++row) {
    const auto dy = static_cast<float>(row - columns.kHalf);
    const F32 x0 = all(place.x + place.shape[0][1] * dy), y0 = all(place.y + place.shape[1][1] * dy);
    for (int k = 0; k < kVectors; ++k) {
      const F32 dx = loadFloats(columns.offset, k);
      const F32 x = x0 + place.shape[0][0] * dx, y = y0 + place.shape[1][0] * dx;
      const I32 column = __builtin_convertvector(x, I32), line = __builtin_convertvector(y, I32);
      store(u[row], k, x - __builtin_convertvector(column, F32));
      store(v[row], k, y - __builtin_convertvector(line, F32));
      const I32 offset = line * static_cast<int32_t>(stride) + column;
      std::memcpy(offsets[row] + k * kLanes, &offset, sizeof offset);
    }
  }
  // Four neighbours to a word. The loads are the same for any processor, and the vectors then wait for none of them.
  uint32_t pixels[kSide][kPatchLanes] = {};
  for (int row = 0; row < kSide; ++row) {
    for (int i = 0; i < kSide; ++i) {
      const uint8_t* pixel = image + offsets[row][i];
      uint16_t above, below;
      std::memcpy(&above, pixel, sizeof above);
      std::memcpy(&below, pixel + stride, sizeof below);
      pixels[row][i] = above | static_cast<uint32_t>(below) << 16;
    }
  }
  for (int row = 0; row < kSide; ++row) {
    for (int k = 0; k < kVectors; ++k) {
      const auto four = load<I32>(pixels[row] + k * kLanes);
      const auto level = [](I32 a) { return __builtin_convertvector(a & 255, F32); };
      const F32 a = level(four), b = level(four >> 8), c = level(four >> 16), d = level(four >> 24);
      const F32 across = loadFloats(u[row], k);
      const F32 above = a + across * (b - a), below = c + across * (d - c);
      store(levels[row], k, above + loadFloats(v[row], k) * (below - above));
    }
  }
}

template <int kSide>
void sampleSquare(const uint8_t* image, ptrdiff_t stride, const PatchMap& place, float (*levels)[kPatchLanes]) {
  (place.upright() ? sampleUpright<kSide> : sampleWarped<kSide>)(image, stride, place, levels);
}

void sample(const uint8_t* image, ptrdiff_t stride, const PatchMap& place, PatchNumbers& levels) {
  sampleSquare<kPatchSide>(image, stride, place, levels.at);
}

void sampleWithDifferences(const uint8_t* image, ptrdiff_t stride, const PatchMap& place, PatchNumbers& levels,
                           PatchNumbers& across, PatchNumbers& down) {
  static constexpr Columns<kPatchSide> columns;
  float rim[kRimSide + 1][kPatchLanes] = {};  // the last row is read past the one before
  sampleSquare<kRimSide>(image, stride, place, rim);
  for (int row = 0; row < kPatchSide; ++row) {
    for (int k = 0; k < kVectors; ++k) {
      const float* centre = rim[row + 1] + 1 + k * kLanes;
      const F32 inside = loadFloats(columns.inside, k);
      store(levels.at[row], k, inside * load<F32>(centre));
      store(across.at[row], k, inside * (load<F32>(centre + 1) - load<F32>(centre - 1)));
      store(down.at[row], k, inside * (load<F32>(centre + kPatchLanes) - load<F32>(centre - kPatchLanes)));
    }
  }
}

float normalize(PatchNumbers& levels) {
  static constexpr Columns<kPatchSide> columns;
  F32 sums[kVectors] = {}, squares[kVectors] = {};
  for (const auto& row : levels.at) {
    for (int k = 0; k < kVectors; ++k) sums[k] += loadFloats(row, k);
  }
  const float mean = sum(sums) / (kPatchSide * kPatchSide);
  for (auto& row : levels.at) {
    for (int k = 0; k < kVectors; ++k) {
      const F32 apart = (loadFloats(row, k) - mean) * loadFloats(columns.inside, k);
      squares[k] += apart * apart;
      store(row, k, apart);
    }
  }
  const float length = std::sqrt(sum(squares)), factor = length > 0 ? 1 / length : 0;
  for (auto& row : levels.at) {
    for (int k = 0; k < kVectors; ++k) store(row, k, factor * loadFloats(row, k));
  }
  return length;
}

float product(const PatchNumbers& a, const PatchNumbers& b) {
  F32 products[kVectors] = {};
  for (int row = 0; row < kPatchSide; ++row) {
    for (int k = 0; k < kVectors; ++k) products[k] += loadFloats(a.at[row], k) * loadFloats(b.at[row], k);
  }
  return sum(products);
}

PatchMoments moments(const PatchNumbers& a, const PatchNumbers& b) {
  static constexpr Columns<kPatchSide> columns;
  F32 one[kVectors] = {}, y[kVectors] = {}, yy[kVectors] = {};
  for (int row = 0; row < kPatchSide; ++row) {
    const auto dy = static_cast<float>(row - kPatchRadius);
    for (int k = 0; k < kVectors; ++k) {
      const F32 product = loadFloats(a.at[row], k) * loadFloats(b.at[row], k);
      one[k] += product;
      y[k] += dy * product;
      yy[k] += dy * dy * product;
    }
  }
  F32 x[kVectors], xx[kVectors], xy[kVectors];
  for (int k = 0; k < kVectors; ++k) {
    const F32 dx = loadFloats(columns.offset, k);
    x[k] = dx * one[k];
    xx[k] = dx * x[k];
    xy[k] = dx * y[k];
  }
  return {sum(one), sum(x), sum(y), sum(xx), sum(xy), sum(yy)};
}

constexpr PatchKernels kKernels = {sample, sampleWithDifferences, normalize, product, moments, sumRows};

}  // namespace
}  // namespace gms_ransac
