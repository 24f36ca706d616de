// The extractor's inner loops over a vector unit V. Included once by the file of each instruction set, which defines
// GMS_RANSAC_VECTOR_BYTES before; everything lies in an unnamed namespace so that no two sets share a function.
#pragma once

#include <cstring>
#include <utility>

#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {
namespace {

/// The base of V: the compiler's own vector types and their operators, unaligned loads and stores, and what compilers
/// make one instruction of. V adds the rest. It replaces a function where its instruction set has a better one.
struct Vectors {
  static constexpr int kBytes = GMS_RANSAC_VECTOR_BYTES, kHalves = kBytes / 2, kFloats = kBytes / 4;
  using U8 [[gnu::vector_size(kBytes)]] = uint8_t;
  using I16 [[gnu::vector_size(kBytes)]] = int16_t;
  using U16 [[gnu::vector_size(kBytes)]] = uint16_t;
  using I32 [[gnu::vector_size(kBytes)]] = int32_t;
  using F32 [[gnu::vector_size(kBytes)]] = float;

  template <typename Vector>
  static Vector loadAny(const void* p) {
    Vector a;
    std::memcpy(&a, p, sizeof a);
    return a;
  }
  template <typename Vector>
  static void store(void* p, const Vector& a) {
    std::memcpy(p, &a, sizeof a);
  }
  static U8 load(const uint8_t* p) { return loadAny<U8>(p); }
  static I16 load(const uint16_t* p) { return loadAny<I16>(p); }
  static I16 load(const int16_t* p) { return loadAny<I16>(p); }
  static F32 load(const float* p) { return loadAny<F32>(p); }
  static U8 set(uint8_t a) { return a + U8{}; }
  static I16 setHalves(int16_t a) { return a + I16{}; }
  static F32 setFloat(float a) { return a - F32{}; }

  static U8 min(U8 a, U8 b) { return a < b ? a : b; }
  static U8 max(U8 a, U8 b) { return a > b ? a : b; }
  static U8 otherMin(U8 a, U8 b) { return min(a, b); }
  static U8 otherMax(U8 a, U8 b) { return max(a, b); }
  static U8 keepGreater(U8 a, U8 b) { return a > b ? a : U8{}; }
  static I32 timesStride(I32 rows, int stride) { return rows * stride; }
  /// The pixels at the offsets with these numbers, which are to be constants of the compiled code.
  template <int... i>
  [[gnu::always_inline]] static U8 read(const uint8_t* centre, const int32_t* offsets, const uint16_t* numbers,
                                        std::integer_sequence<int, i...>) {
    const uint8_t pixels[kBytes] = {centre[offsets[numbers[i]]]...};
    return load(pixels);
  }
  /// Bytes of an entry of Disc from `part` on, with the pixels of its two rows.
  static U8 loadPart(const uint8_t* below, const uint8_t* above, int part) {
    constexpr int kRow = detail::Disc::kRow;
    return load((part < kRow ? below : above) + part % kRow);
  }
  /// Sums of the products of neighbours; below, of neighbours.
  static I16 multiplyPairs(U8 a, const int8_t* b) {
    const auto both = loadAny<I16>(b);
    const auto pairs = reinterpret_cast<U16>(a);
    return reinterpret_cast<I16>(pairs & 255) * (both << 8 >> 8) + reinterpret_cast<I16>(pairs >> 8) * (both >> 8);
  }
  static I32 addPairs(I16 a) {
    const auto pairs = reinterpret_cast<I32>(a);
    return (pairs << 16 >> 16) + (pairs >> 16);
  }
  static int sum(I32 a) {
    int total = 0;
    for (int i = 0; i < kFloats; ++i) total += a[i];
    return total;
  }
  static int storeColumns(uint64_t mask, int x, uint16_t* columns) {
    int count = 0;
    for (; mask; mask &= mask - 1) columns[count++] = static_cast<uint16_t>(x + __builtin_ctzll(mask));
    return count;
  }
};

/// The seven rows that the circle about a pixel of the middle one touches.
struct CircleRows {
  const uint8_t* row[7];

  CircleRows(const uint8_t* middle, ptrdiff_t stride) {
    for (int i = 0; i < 7; ++i) row[i] = middle + (i - 3) * stride;
  }
  /// Pixel i of the circle about column x, counted from the lowest.
  template <int i>
  const uint8_t* at(ptrdiff_t x) const {
    constexpr int kColumn[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
    return row[3 + kColumn[(i + 4) % 16]] + x + kColumn[i % 16];
  }
};

/// The best over the 16 arcs of nine contiguous pixels of the worst pixel in the arc; with minimum as kWorse, the
/// brightness that some arc reaches everywhere. Loads a pixel wherever it is used: there are too few registers.
template <typename V, auto kWorse, auto kBetter, auto kOtherWorse, int... j>
[[gnu::always_inline]] inline auto extremeOfArcs(const CircleRows& rows, ptrdiff_t x,
                                                 std::integer_sequence<int, j...>) {
  using U8 = typename V::U8;
  const U8 two[8] = {kOtherWorse(V::load(rows.at<2 * j + 1>(x)), V::load(rows.at<2 * j + 2>(x)))...};
  const U8 four[8] = {kOtherWorse(two[j], two[(j + 1) % 8])...};
  // Pixels 2j+1..2j+8 lie in two arcs of nine: the one that begins in pixel 2j and the one that ends in pixel 2j+9.
  const auto arcs = [&](const U8& eight, const uint8_t* before, const uint8_t* after) {
    return kWorse(eight, kBetter(V::load(before), V::load(after)));
  };
  U8 best = arcs(kWorse(four[0], four[2]), rows.at<0>(x), rows.at<9>(x));
  ((best = kBetter(best, arcs(kWorse(four[j], four[(j + 2) % 8]), rows.at<2 * j>(x), rows.at<2 * j + 9>(x)))), ...);
  return best;
}

/// Contrasts of the blocks of a row.
template <typename V>
class ContrastSearch {
 public:
  using U8 = typename V::U8;

  ContrastSearch(const uint8_t* row, ptrdiff_t stride, int floor)
      : rows_(row, stride), floor_(V::set(static_cast<uint8_t>(floor))) {}

  /// Not less than the contrasts: nine contiguous pixels hold at least two adjacent ones of these four.
  U8 bound(ptrdiff_t x) const {
    const U8 centre = V::load(rows_.row[3] + x);
    const U8 south = V::load(rows_.at<0>(x)), east = V::load(rows_.at<4>(x));
    const U8 north = V::load(rows_.at<8>(x)), west = V::load(rows_.at<12>(x));
    return V::max(V::subtract(V::min(V::max(south, north), V::max(east, west)), centre),
                  V::subtract(centre, V::max(V::min(south, north), V::min(east, west))));
  }
  [[gnu::always_inline]] U8 contrasts(ptrdiff_t x) const {
    constexpr auto kArcs = std::make_integer_sequence<int, 8>();
    const U8 centre = V::load(rows_.row[3] + x);
    const U8 bright = V::subtract(extremeOfArcs<V, V::min, V::max, V::otherMin>(rows_, x, kArcs), centre);
    const U8 dark = V::subtract(centre, extremeOfArcs<V, V::max, V::min, V::otherMax>(rows_, x, kArcs));
    return V::keepGreater(V::max(bright, dark), floor_);
  }

 private:
  CircleRows rows_;
  U8 floor_;
};

template <typename V>
int contrastRow(const uint8_t* image, ptrdiff_t stride, int width, const CornerFloors& floors, uint8_t* contrast,
                const BlockRow& blocks) {
  const ContrastSearch<V> search(image, stride, floors.contrast);
  const auto passed = V::set(static_cast<uint8_t>(floors.passedContrast()));
  // Lists instead of branches, which would be predicted badly: about every other block goes on.
  uint8_t* const passed_over = blocks.passed_over;
  uint16_t* const candidates = blocks.candidates;
  std::fill_n(passed_over, (width + V::kBytes - 1) / V::kBytes, floors.passBlocks());
  ptrdiff_t searched = 0, found = 0;
  for (ptrdiff_t x = 0; x < width; x += V::kBytes) {
    V::store(contrast + x, V::set(0));
    candidates[searched] = static_cast<uint16_t>(x);
    searched += V::anyGreater(search.bound(x), passed);
  }
  for (ptrdiff_t i = 0; i < searched; ++i) {
    const uint16_t x = candidates[i];
    const auto contrasts = search.contrasts(x);
    V::store(contrast + x, contrasts);
    passed_over[x / V::kBytes] = 0;
    candidates[found] = x;
    found += V::anyGreater(contrasts, passed);
  }
  return static_cast<int>(found);
}

/// Searches a block of `image`, those above and below, and `left` and `right` of these, where they were passed over.
/// Seldom called, so that its loop stays out of the caller's.
template <typename V>
[[gnu::noinline]] void searchPassedOver(int block, int left, int right, const uint8_t* image, uint8_t* contrast,
                                        ptrdiff_t stride, const BlockRow (&rows)[3], int floor) {
  for (int row = 0; row < 3; ++row) {
    const ptrdiff_t from = (row - 1) * stride;
    const ContrastSearch<V> search(image + from, stride, floor);
    for (int i = block - left; i <= block + right; ++i) {
      if (!rows[row].passed_over[i]) continue;
      const ptrdiff_t x = (i - block) * V::kBytes;
      V::store(contrast + from + x, search.contrasts(x));
      rows[row].passed_over[i] = 0;
    }
  }
}

template <typename V>
struct Neighbours {
  using U8 = typename V::U8;
  U8 west, east, north_west, north, north_east, south_west, south, south_east;

  Neighbours(const uint8_t* at, ptrdiff_t stride)
      : west(V::load(at - 1)),
        east(V::load(at + 1)),
        north_west(V::load(at - stride - 1)),
        north(V::load(at - stride)),
        north_east(V::load(at - stride + 1)),
        south_west(V::load(at + stride - 1)),
        south(V::load(at + stride)),
        south_east(V::load(at + stride + 1)) {}

  U8 greatest() const {
    return V::max(V::max(V::max(west, east), V::max(north, south)),
                  V::max(V::max(north_west, north_east), V::max(south_west, south_east)));
  }
  U8 mean() const {
    return V::average(V::average(V::average(west, east), V::average(north, south)),
                      V::average(V::average(north_west, north_east), V::average(south_west, south_east)));
  }
};

template <typename V>
MaximaCount maximaRow(const uint8_t* image, uint8_t* contrast, ptrdiff_t stride, const BlockRow (&rows)[3],
                      int candidates, const CornerFloors& floors, int begin, int end, uint16_t* columns,
                      uint8_t* strength) {
  using U8 = typename V::U8;
  const U8 passed = V::set(static_cast<uint8_t>(floors.passedContrast()));
  const U8 strength_floor = V::set(static_cast<uint8_t>(floors.strength));
  const auto passedOver = [&](int i) {
    return rows[0].passed_over[i] | rows[1].passed_over[i] | rows[2].passed_over[i];
  };
  MaximaCount count;
  for (int i = 0; i < candidates; ++i) {
    const int x = rows[1].candidates[i];
    const uint8_t* row = contrast + x;
    const U8 centre = V::load(row);
    const Neighbours<V> neighbours(row, stride);
    uint64_t mask = V::greaterMask(centre, V::max(neighbours.greatest(), passed));
    if (x < begin) mask &= ~uint64_t{0} << (begin - x);
    if (end - x < V::kBytes) mask &= (uint64_t{1} << (end - x)) - 1;
    if (!mask) continue;
    // Maxima touch this block, and its neighbours if they lie at its ends.
    const int block = x / V::kBytes, left = static_cast<int>(mask & 1), right = mask >> (V::kBytes - 1) & 1;
    if (passedOver(block) | (passedOver(block - 1) & left) | (passedOver(block + 1) & right)) {
      searchPassedOver<V>(block, left, right, image + x, contrast + x, stride, rows, floors.contrast);
      --i;  // this block once more
      continue;
    }
    const U8 mean = neighbours.mean(), value = V::addSaturated(mean, V::average(mean, centre));
    V::store(strength + x, value);
    count.all += __builtin_popcountll(mask);
    count.strong += V::storeColumns(mask & V::greaterMask(value, strength_floor), x, columns + count.strong);
  }
  return count;
}

template <typename V>
void resizeRow(const uint8_t* source, const ResizeTable& table, int width, uint16_t* target) {
  if constexpr (V::kShuffles) {
    if (!table.window.empty()) {
      const int32_t* windows = table.window.data();
      const uint8_t *firsts = table.first.data(), *seconds = table.second.data();
      const uint16_t* weights = table.weight.data();
      for (ptrdiff_t x = 0; x < width; x += V::kHalves, windows += V::kHalves / ResizeTable::kGroup) {
        const auto window = V::loadWindows(source, windows);
        const auto first = reinterpret_cast<typename V::U16>(V::shuffle(window, firsts + 2 * x));
        const auto second = reinterpret_cast<typename V::U16>(V::shuffle(window, seconds + 2 * x));
        // Modulo 65536, which the result does not reach.
        V::store(target + x, (first << 8) + V::template loadAny<typename V::U16>(weights + x) * (second - first));
      }
      return;
    }
  }
  for (int x = 0; x < width; ++x) {
    const uint8_t* pixel = source + table.offset[x];
    target[x] = static_cast<uint16_t>(pixel[0] * (256 - table.weight[x]) + pixel[1] * table.weight[x]);
  }
}

template <typename V>
void blendRows(const uint16_t* upper, const uint16_t* lower, int weight, int width, uint8_t* target) {
  for (int x = 0; x < width; x += V::kHalves) {
    V::storeBlend(target + x, V::load(upper + x), V::load(lower + x), weight);
  }
}

template <typename V>
void widenRow(const uint8_t* source, int width, float* target) {
  for (int x = 0; x < width; x += V::kFloats) V::store(target + x, V::loadAsFloats(source + x));
}

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
  auto sum = weights[kBlurRadius] * V::load(pixels - kBlurRadius);
  for (int k = 1; k < kBlurTaps; ++k) {
    sum = V::multiplyAdd(weights[k - kBlurRadius], V::load(pixels + k - kBlurRadius), sum);
  }
  return sum;
}

template <typename V>
inline typename V::F32 blurAlongColumn(const BlurWeights<V>& weights, const typename V::F32* rows) {
  auto sum = weights[0] * rows[kBlurRadius];
  for (int k = 1; k <= kBlurRadius; ++k) {
    sum = V::multiplyAdd(weights[k], rows[kBlurRadius + k] + rows[kBlurRadius - k], sum);
  }
  return sum;
}

template <typename V>
void blurTwoRows(const float* const pixels[2], float* const rows[kBlurTaps + 1], int width, uint8_t* const target[2]) {
  const BlurWeights<V> weights;
  // Copies, because the compiler reads the arguments again after every store.
  const float* const pixel[2] = {pixels[0], pixels[1]};
  uint8_t* const blurred[2] = {target[0], target[1]};
  float* const row[kBlurTaps + 1] = {rows[0], rows[1], rows[2], rows[3], rows[4], rows[5], rows[6], rows[7]};
  for (ptrdiff_t x = 0; x < width; x += V::kFloats) {
    typename V::F32 column[kBlurTaps + 1];
#pragma GCC unroll 2
    for (int k = 0; k < 2; ++k) {
      column[kBlurTaps - 1 + k] = blurAlongRow(weights, pixel[k] + x);
      V::store(row[kBlurTaps - 1 + k] + x, column[kBlurTaps - 1 + k]);
    }
    // After the stores: at the top of the image the rows above are reflections of the new ones.
    for (int k = 0; k < kBlurTaps - 1; ++k) column[k] = V::load(row[k] + x);
    for (int k = 0; k < 2; ++k) V::storeRounded(blurred[k] + x, blurAlongColumn(weights, column + k));
  }
}

template <typename V>
void moments(const uint8_t* centre, ptrdiff_t stride, int& m10, int& m01) {
  using detail::Disc;
  using detail::kDisc;
  constexpr int kTogether = 2;  // rows below, and above, whose sums 16 bits hold: 4 * 255 * (14 + 15) is the most
  const uint8_t *below = centre - kAngleRadius, *above = below;
  typename V::I32 sum_x{}, sum_y{};
  for (int v = 0; v <= kAngleRadius; v += kTogether) {
    typename V::I16 x{}, y{};
    for (int k = v; k < v + kTogether; ++k, below += stride, above -= stride) {
      for (int part = 0; part < 2 * Disc::kRow; part += V::kBytes) {
        const auto pixels = V::loadPart(below, above, part);
        x += V::multiplyPairs(pixels, kDisc.x[k] + part);
        y += V::multiplyPairs(pixels, kDisc.y[k] + part);
      }
    }
    sum_x += V::addPairs(x);
    sum_y += V::addPairs(y);
  }
  m10 = V::sum(sum_x);
  m01 = V::sum(sum_y);
}

/// Offsets from the keypoint of points rotated with it, as cv::ORB's compiled code computes them: two roundings
/// each, never fused.
template <typename V>
struct Rotated {
  typename V::I32 column, row;

  Rotated(const float* x, const float* y, typename V::F32 cosine, typename V::F32 sine) {
    const auto from_x = V::load(x), from_y = V::load(y);
    column = V::rounded(from_x * cosine - from_y * sine);
    row = V::rounded(from_x * sine + from_y * cosine);
  }
};

constexpr detail::QuarterPattern kQuarterPattern;

/// Bits of the tests from `first` on. The places of the offsets are constants of the compiled code.
template <typename V, int first>
void testPixels(const uint8_t* centre, const int32_t* offsets, uint8_t* descriptor) {
  constexpr auto kLanes = std::make_integer_sequence<int, V::kBytes>();
  const auto* slots = kQuarterPattern.slot;
  const uint64_t bits = V::greaterMask(V::read(centre, offsets, slots[1] + first, kLanes),
                                       V::read(centre, offsets, slots[0] + first, kLanes));
  std::memcpy(descriptor + first / 8, &bits, V::kBytes / 8);
}

template <typename V, int... group>
void testAllPixels(const uint8_t* centre, const int32_t* offsets, uint8_t* descriptor,
                   std::integer_sequence<int, group...>) {
  (testPixels<V, group * V::kBytes>(centre, offsets, descriptor), ...);
}

template <typename V>
void describe(const uint8_t* centre, ptrdiff_t stride, float cosine, float sine, uint8_t* descriptor) {
  constexpr int kPoints = detail::QuarterPattern::kPoints;
  const auto c = V::setFloat(cosine), s = V::setFloat(sine);
  alignas(64) int32_t offsets[detail::QuarterPattern::kTurns * kPoints];
  for (int i = 0; i < kPoints; i += V::kFloats) {
    const Rotated<V> point(kQuarterPattern.x + i, kQuarterPattern.y + i, c, s);
    const auto here = V::timesStride(point.row, static_cast<int>(stride)) + point.column;
    const auto turned = V::timesStride(point.column, static_cast<int>(stride)) - point.row;
    V::store(offsets + i, here);
    V::store(offsets + kPoints + i, turned);
    V::store(offsets + 2 * kPoints + i, -here);
    V::store(offsets + 3 * kPoints + i, -turned);
  }
  testAllPixels<V>(centre, offsets, descriptor, std::make_integer_sequence<int, kOrbTests / V::kBytes>());
}

/// The same for a V that can look up bytes in registers: reads each point of the pattern once, with kRead.
template <typename V, auto kRead>
void describeByLookUp(const uint8_t* centre, ptrdiff_t stride, float cosine, float sine, uint8_t* descriptor) {
  using detail::DistinctPattern;
  using detail::kDistinctPattern;
  const auto c = V::setFloat(cosine), s = V::setFloat(sine);
  alignas(64) int32_t offset[DistinctPattern::kPoints];
  for (int i = 0; i < DistinctPattern::kPoints; i += V::kFloats) {
    const Rotated<V> point(kDistinctPattern.x + i, kDistinctPattern.y + i, c, s);
    V::store(offset + i, V::timesStride(point.row, static_cast<int>(stride)) + point.column);
  }
  typename V::U8 pixels[DistinctPattern::kPoints / V::kBytes];
  for (int i = 0; i < DistinctPattern::kPoints / V::kBytes; ++i) pixels[i] = kRead(centre, offset + i * V::kBytes);
  for (int i = 0; i < kOrbTests; i += V::kBytes) {
    const uint64_t bits = V::greaterMask(V::lookUp(pixels, 1, i), V::lookUp(pixels, 0, i));
    std::memcpy(descriptor + i / 8, &bits, sizeof bits);
  }
}

template <typename V>
void gradientRow(const uint8_t* row, int width, uint8_t* gradients) {
  const auto most = V::set(kMostGradient);
  for (int x = 0; x < width; x += V::kBytes) {
    const auto west = V::load(row + x - 1), east = V::load(row + x + 1);
    V::store(gradients + x, most + V::min(V::subtract(east, west), most) - V::min(V::subtract(west, east), most));
  }
}

template <typename V>
void compareRow(const uint8_t* left, const uint8_t* right, ptrdiff_t stride, int count, int16_t* sums) {
  constexpr int kTogether = 255 / (2 * kMostGradient);  // differences whose sum is a byte
  for (int k = 0; k < count; k += V::kBytes) {
    typename V::U16 even{}, odd{};
    for (int y = 0; y < kRowWindowHeight; ++y) {
      const uint8_t *a = left + y * stride, *b = right + y * stride + k;
      for (int begin = 0; begin < kRowWindowWidth; begin += kTogether) {
        typename V::U8 sum{};
        for (int x = begin; x < std::min(begin + kTogether, kRowWindowWidth); ++x) {
          const typename V::U8 one = V::set(a[x]), other = V::load(b + x);
          sum += V::max(one, other) - V::min(one, other);
        }
        even += reinterpret_cast<typename V::U16>(sum) & 255;
        odd += reinterpret_cast<typename V::U16>(sum) >> 8;
      }
    }
    for (int i = 0; i < V::kHalves; ++i) {
      sums[k + 2 * i] = static_cast<int16_t>(even[i]);
      sums[k + 2 * i + 1] = static_cast<int16_t>(odd[i]);
    }
  }
}

template <typename V>
FeatureKernels kernelsOf(decltype(FeatureKernels::describe) describe_keypoint = describe<V>,
                         decltype(FeatureKernels::compareRow) compare_row = compareRow<V>) {
  return {resizeRow<V>,   blendRows<V>, contrastRow<V>,    maximaRow<V>,   widenRow<V>,
          blurTwoRows<V>, moments<V>,   describe_keypoint, gradientRow<V>, compare_row};
}

}  // namespace
}  // namespace gms_ransac
