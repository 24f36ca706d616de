#include "features/kernels.h"

#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace gms_ransac {

namespace {

/// Start of the interpolation and the share of the second pixel, in OpenCV's rounding.
void interpolate(double position, int size, uint16_t& offset, uint16_t& weight) {
  const int whole = static_cast<int>(std::floor(position));
  offset = static_cast<uint16_t>(whole < 0 ? 0 : whole < size ? whole : size - 1);
  const bool inside = whole >= 0 && whole < size - 1;
  weight = inside ? static_cast<uint16_t>(std::lrint((position - whole) * 256)) : 0;
}

}  // namespace

void ResizeTable::build(int source, int target) {
  const double scale = 1.0 / (static_cast<double>(target) / source);
  const int padded = (target + kPadding - 1) / kPadding * kPadding + kPadding;
  offset.assign(padded, 0);
  weight.assign(padded, 0);
  for (int x = 0; x < target; ++x) interpolate(scale * (x + 0.5) - 0.5, source, offset[x], weight[x]);

  window.assign(padded / kGroup, 0);
  first.assign(2 * padded, 0);
  second.assign(2 * padded, 0);
  for (int x = 0; x < target; ++x) {
    const int base = offset[x / kGroup * kGroup];
    const int position = offset[x] - base;
    if (position + 1 >= kWindow) {
      window.clear();
      return;
    }
    window[x / kGroup] = base;
    constexpr uint8_t kZero = 0x80;  // what a byte shuffle turns into zero
    first[2 * x] = static_cast<uint8_t>(position);
    second[2 * x] = static_cast<uint8_t>(position + 1);
    first[2 * x + 1] = second[2 * x + 1] = kZero;
  }
}

const FeatureKernels& featureKernels(SimdLevel level) {
  if (!simdLevelSupported(level)) {
    throw std::invalid_argument("simd is " + toString(level) + ", which this processor does not have");
  }
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512) return detail::avx512FeatureKernels();
  if (level == SimdLevel::kAvx2) return detail::avx2FeatureKernels();
#elif defined(__aarch64__)
  if (level == SimdLevel::kNeon) return detail::neonFeatureKernels();
#endif
  return detail::scalarFeatureKernels();
}

namespace detail {

const float kBlurKernel[kBlurTaps] = {0.0701593235F, 0.131074876F, 0.190712824F, 0.216105938F,
                                      0.190712824F,  0.131074876F, 0.0701593235F};

namespace {

/// Half widths of the disc's rows, made symmetric about the diagonals as cv::ORB does.
constexpr int kDiscHalfWidth[kAngleRadius + 1] = {15, 15, 15, 15, 14, 14, 14, 13, 13, 12, 11, 10, 9, 8, 6, 3};

constexpr Disc makeDisc() {
  Disc disc{};
  for (int i = 0; i < Disc::kRow; ++i) {
    const int u = i - kAngleRadius;
    for (int v = 0; v <= kAngleRadius; ++v) {
      if (u > kDiscHalfWidth[v] || -u > kDiscHalfWidth[v]) continue;
      disc.x[v][i] = static_cast<int8_t>(u);
      if (v > 0) disc.x[v][Disc::kRow + i] = disc.x[v][i];
      disc.y[v][i] = static_cast<int8_t>(v);
      disc.y[v][Disc::kRow + i] = static_cast<int8_t>(-v);
    }
  }
  return disc;
}

DistinctPattern numberPoints() {
  DistinctPattern pattern{};
  std::map<std::pair<int, int>, int> numbers;
  for (int i = 0; i < kOrbTests; ++i) {
    const OrbTest& test = kOrbPattern[i];
    const std::pair<int, int> ends[2] = {{test.x0, test.y0}, {test.x1, test.y1}};
    for (int end = 0; end < 2; ++end) {
      const int number = numbers.emplace(ends[end], static_cast<int>(numbers.size())).first->second;
      pattern.x[number] = static_cast<float>(ends[end].first);
      pattern.y[number] = static_cast<float>(ends[end].second);
      pattern.place[end][i] = static_cast<uint8_t>(number % DistinctPattern::kTable);
      pattern.in_table[end][number / DistinctPattern::kTable][i / 64] |= uint64_t{1} << i % 64;
    }
  }
  return pattern;
}

}  // namespace

const Disc kDisc = makeDisc();
const DistinctPattern kDistinctPattern = numberPoints();

}  // namespace detail

}  // namespace gms_ransac
