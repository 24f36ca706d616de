// The extractor's inner loops over an abstract vector unit V. Included once by the file of each instruction set, whose
// V wraps its intrinsics; everything lies in an unnamed namespace so that no two sets share a function.
//
// V provides: kBytes, kHalves, kFloats (lanes of U8, I16, F32) and the operations used below, unaligned throughout.
#pragma once

#include <cstring>

#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {
namespace {

/// Circle of FAST-9/16, clockwise from below the centre.
constexpr int kCircleX[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
constexpr int kCircleY[16] = {3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1, 0, 1, 2, 3};

/// The best over the 16 arcs of nine contiguous pixels of the worst pixel in the arc; with minimum as `worse`, the
/// brightness that some arc reaches everywhere.
template <typename U8, typename Worse, typename Better, typename OtherWorse>
inline U8 extremeOfArcs(const U8 (&p)[16], Worse worse, Better better, OtherWorse other_worse, U8 worst) {
  U8 two[8], four[8];
  for (int j = 0; j < 8; ++j) two[j] = other_worse(p[2 * j + 1], p[(2 * j + 2) % 16]);
  for (int j = 0; j < 8; ++j) four[j] = other_worse(two[j], two[(j + 1) % 8]);
  // Pixels 2j+1..2j+8 lie in two arcs of nine: the one that begins in pixel 2j and the one that ends in pixel 2j+9.
  U8 best = worst;
  for (int j = 0; j < 8; ++j) {
    const U8 eight = worse(four[j], four[(j + 2) % 8]);
    best = better(best, worse(eight, better(p[2 * j], p[(2 * j + 9) % 16])));
  }
  return best;
}

template <typename V>
void contrastRow(const uint8_t* image, ptrdiff_t stride, int width, int floor, uint8_t* contrast) {
  using U8 = typename V::U8;
  ptrdiff_t offset[16];
  for (int i = 0; i < 16; ++i) offset[i] = kCircleY[i] * stride + kCircleX[i];
  const U8 floor_vector = V::set(static_cast<uint8_t>(floor));
  for (int x = 0; x < width; x += V::kBytes) {
    const uint8_t* pixel = image + x;
    const U8 centre = V::load(pixel);
    U8 p[16];
    for (int i = 0; i < 16; i += 4) p[i] = V::load(pixel + offset[i]);
    // Nine contiguous pixels hold at least two adjacent ones of these four, which bounds the contrast from above.
    const U8 bright_bound = V::min(V::max(p[0], p[8]), V::max(p[4], p[12]));
    const U8 dark_bound = V::max(V::min(p[0], p[8]), V::min(p[4], p[12]));
    const bool bright = V::anyGreater(V::subtract(bright_bound, centre), floor_vector);
    const bool dark = V::anyGreater(V::subtract(centre, dark_bound), floor_vector);
    if (!bright && !dark) {
      V::store(contrast + x, V::set(0));
      continue;
    }
    for (int i = 0; i < 16; ++i) {
      if (i % 4 != 0) p[i] = V::load(pixel + offset[i]);
    }
    U8 value = V::set(0);
    if (bright) value = V::subtract(extremeOfArcs(p, V::min, V::max, V::otherMin, V::set(0)), centre);
    if (dark) value = V::max(value, V::subtract(centre, extremeOfArcs(p, V::max, V::min, V::otherMax, V::set(255))));
    V::store(contrast + x, V::keepGreater(value, floor_vector));
  }
}

/// Writes x + i for every bit i that is set; their number.
inline int storeSetBits(uint64_t mask, int x, uint16_t* columns) {
  int count = 0;
  for (; mask; mask &= mask - 1) columns[count++] = static_cast<uint16_t>(x + __builtin_ctzll(mask));
  return count;
}

template <typename V>
int maximaRow(const uint8_t* contrast, ptrdiff_t stride, int begin, int end, uint16_t* columns, uint8_t* strength) {
  using U8 = typename V::U8;
  int count = 0;
  for (int x = begin; x < end; x += V::kBytes) {
    const uint8_t* row = contrast + x;
    const U8 centre = V::load(row);
    if (!V::anyGreater(centre, V::set(0))) continue;
    const U8 west = V::load(row - 1), east = V::load(row + 1);
    const U8 north_west = V::load(row - stride - 1), north = V::load(row - stride),
             north_east = V::load(row - stride + 1);
    const U8 south_west = V::load(row + stride - 1), south = V::load(row + stride),
             south_east = V::load(row + stride + 1);
    const U8 around = V::max(V::max(V::max(west, east), V::max(north, south)),
                             V::max(V::max(north_west, north_east), V::max(south_west, south_east)));
    uint64_t mask = V::greaterMask(centre, around);
    if (end - x < V::kBytes) mask &= (uint64_t{1} << (end - x)) - 1;
    if (!mask) continue;
    const U8 mean = V::average(V::average(V::average(west, east), V::average(north, south)),
                               V::average(V::average(north_west, north_east), V::average(south_west, south_east)));
    V::store(strength + x, V::addSaturated(mean, V::average(mean, centre)));
    count += V::storeColumns(mask, x, columns + count);
  }
  return count;
}

template <typename V>
void resizeRow(const uint8_t* source, const ResizeTable& table, int width, uint16_t* target) {
  if (!V::kShuffles || table.window.empty()) {
    for (int x = 0; x < width; ++x) {
      const uint8_t* pixel = source + table.offset[x];
      target[x] = static_cast<uint16_t>(pixel[0] * (256 - table.weight[x]) + pixel[1] * table.weight[x]);
    }
    return;
  }
  for (int x = 0; x < width; x += V::kHalves) {
    const auto window = V::loadWindows(source, table.window.data() + x / ResizeTable::kGroup);
    const auto first = V::shuffle(window, table.first.data() + 2 * x);
    const auto second = V::shuffle(window, table.second.data() + 2 * x);
    const auto weight = V::loadHalves(table.weight.data() + x);
    // 256 * first + weight * (second - first), modulo 65536, which the result does not reach.
    V::storeHalves(target + x, V::blendBytes(first, second, weight));
  }
}

template <typename V>
void blendRows(const uint16_t* upper, const uint16_t* lower, int weight, int width, uint8_t* target) {
  for (int x = 0; x < width; x += V::kHalves) {
    V::storeNarrow(target + x, V::blendHalves(V::loadHalves(upper + x), V::loadHalves(lower + x), weight));
  }
}

template <typename V>
void widenRow(const uint8_t* source, int width, float* target) {
  for (int x = 0; x < width; x += V::kFloats) V::storeFloats(target + x, V::loadAsFloats(source + x));
}

/// The Gaussian is symmetric: one half of it and the middle.
template <typename V>
struct BlurWeights {
  typename V::F32 at[kBlurRadius + 1];

  BlurWeights() {
    for (int k = 0; k <= kBlurRadius; ++k) at[k] = V::setFloat(detail::kBlurKernel[kBlurRadius + k]);
  }
  typename V::F32 operator[](int distance) const { return at[distance < 0 ? -distance : distance]; }
};

template <typename V>
inline typename V::F32 blurAlongRow(const BlurWeights<V>& weights, const float* pixels) {
  auto sum = V::multiply(weights[kBlurRadius], V::loadFloats(pixels - kBlurRadius));
  for (int k = 1; k < kBlurTaps; ++k) {
    sum = V::multiplyAdd(weights[k - kBlurRadius], V::loadFloats(pixels + k - kBlurRadius), sum);
  }
  return sum;
}

template <typename V>
inline typename V::F32 blurAlongColumn(const BlurWeights<V>& weights, const typename V::F32* rows) {
  auto sum = V::multiply(weights[0], rows[kBlurRadius]);
  for (int k = 1; k <= kBlurRadius; ++k) {
    sum = V::multiplyAdd(weights[k], V::add(rows[kBlurRadius + k], rows[kBlurRadius - k]), sum);
  }
  return sum;
}

template <typename V>
void blurRow(const float* pixels, int width, float* target) {
  const BlurWeights<V> weights;
  for (int x = 0; x < width; x += V::kFloats) V::storeFloats(target + x, blurAlongRow(weights, pixels + x));
}

template <typename V>
void blurColumns(const float* const rows[kBlurTaps], int width, uint8_t* target) {
  const BlurWeights<V> weights;
  for (int x = 0; x < width; x += V::kFloats) {
    typename V::F32 column[kBlurTaps];
    for (int k = 0; k < kBlurTaps; ++k) column[k] = V::loadFloats(rows[k] + x);
    V::storeRounded(target + x, blurAlongColumn(weights, column));
  }
}

template <typename V>
void blurTwoRows(const float* const pixels[2], float* const rows[kBlurTaps + 1], int width, uint8_t* const target[2]) {
  const BlurWeights<V> weights;
  for (int x = 0; x < width; x += V::kFloats) {
    typename V::F32 column[kBlurTaps + 1];
    for (int k = 0; k < 2; ++k) {
      column[kBlurTaps - 1 + k] = blurAlongRow(weights, pixels[k] + x);
      V::storeFloats(rows[kBlurTaps - 1 + k] + x, column[kBlurTaps - 1 + k]);
    }
    // After the stores: at the top of the image the rows above are reflections of the new ones.
    for (int k = 0; k < kBlurTaps - 1; ++k) column[k] = V::loadFloats(rows[k] + x);
    for (int k = 0; k < 2; ++k) V::storeRounded(target[k] + x, blurAlongColumn(weights, column + k));
  }
}

template <typename V>
void moments(const uint8_t* centre, ptrdiff_t stride, int& m10, int& m01) {
  using I16 = typename V::I16;
  m10 = m01 = 0;
  for (int column = 0; column < 2 * kAngleRadius + 2; column += V::kHalves) {
    const uint8_t* pixel = centre - kAngleRadius + column;
    I16 sum = V::bitAnd(V::loadAsHalves(pixel), V::loadSigned(detail::kDisc.mask[0] + column));
    I16 lever = V::setHalves(0);  // at most 255 * (1 + ... + 15) = 30600: 16 bits hold it
    for (int v = 1; v <= kAngleRadius; ++v) {
      const I16 mask = V::loadSigned(detail::kDisc.mask[v] + column);
      const I16 below = V::bitAnd(V::loadAsHalves(pixel + v * stride), mask);
      const I16 above = V::bitAnd(V::loadAsHalves(pixel - v * stride), mask);
      sum = V::addHalves(sum, V::addHalves(below, above));
      lever = V::addHalves(lever,
                           V::multiplyHalves(V::setHalves(static_cast<int16_t>(v)), V::subtractHalves(below, above)));
    }
    m10 += V::dot(sum, V::loadSigned(detail::kDisc.column + column));
    m01 += V::dot(lever, V::setHalves(1));
  }
}

/// Offsets from the keypoint of points that are turned with it, as cv::ORB's compiled code computes them: two roundings
/// each, never fused.
template <typename V>
inline auto rotate(const float* x, const float* y, typename V::F32 cosine, typename V::F32 sine, ptrdiff_t stride) {
  using F32 = typename V::F32;
  const F32 from_x = V::loadFloats(x), from_y = V::loadFloats(y);
  const F32 column = V::subtractFloats(V::multiply(from_x, cosine), V::multiply(from_y, sine));
  const F32 row = V::add(V::multiply(from_x, sine), V::multiply(from_y, cosine));
  return V::offsets(column, row, static_cast<int>(stride));
}

template <typename V>
void describe(const uint8_t* centre, ptrdiff_t stride, float cosine, float sine, uint8_t* descriptor) {
  const auto c = V::setFloat(cosine), s = V::setFloat(sine);
  alignas(64) int32_t offset[2][kOrbTests];
  for (int end = 0; end < 2; ++end) {
    const float *x = detail::kPatternCoordinates.x[end], *y = detail::kPatternCoordinates.y[end];
    for (int i = 0; i < kOrbTests; i += V::kFloats)
      V::storeOffsets(offset[end] + i, rotate<V>(x + i, y + i, c, s, stride));
  }
  for (int i = 0; i < kOrbTests; i += 8) {
    unsigned bits = 0;
    for (int j = 7; j >= 0; --j) bits = 2 * bits + (centre[offset[0][i + j]] < centre[offset[1][i + j]]);
    descriptor[i / 8] = static_cast<uint8_t>(bits);
  }
}

/// The same for a V that can look up bytes in registers: reads each point of the pattern once.
template <typename V, typename Read>
inline void describeByLookUp(ptrdiff_t stride, float cosine, float sine, uint8_t* descriptor, const Read& read) {
  using detail::DistinctPattern;
  using detail::kDistinctPattern;
  const auto c = V::setFloat(cosine), s = V::setFloat(sine);
  alignas(64) int32_t offset[DistinctPattern::kPoints];
  for (int i = 0; i < DistinctPattern::kPoints; i += V::kFloats) {
    V::storeOffsets(offset + i, rotate<V>(kDistinctPattern.x + i, kDistinctPattern.y + i, c, s, stride));
  }
  typename V::U8 pixels[DistinctPattern::kPoints / V::kBytes];
  for (int i = 0; i < DistinctPattern::kPoints / V::kBytes; ++i) pixels[i] = read(offset + i * V::kBytes);
  for (int i = 0; i < kOrbTests; i += V::kBytes) {
    const uint64_t bits = V::lessMask(V::lookUp(pixels, 0, i), V::lookUp(pixels, 1, i));
    std::memcpy(descriptor + i / 8, &bits, sizeof bits);
  }
}

template <typename V>
FeatureKernels kernelsOf(decltype(FeatureKernels::describe) describe_keypoint = describe<V>) {
  FeatureKernels kernels;
  kernels.resizeRow = resizeRow<V>;
  kernels.blendRows = blendRows<V>;
  kernels.contrastRow = contrastRow<V>;
  kernels.maximaRow = maximaRow<V>;
  kernels.widenRow = widenRow<V>;
  kernels.blurRow = blurRow<V>;
  kernels.blurColumns = blurColumns<V>;
  kernels.blurTwoRows = blurTwoRows<V>;
  kernels.moments = moments<V>;
  kernels.describe = describe_keypoint;
  return kernels;
}

}  // namespace
}  // namespace gms_ransac
