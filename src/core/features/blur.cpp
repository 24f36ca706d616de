#include "features/blur.h"

#include <algorithm>

namespace gms_ransac {

namespace {
constexpr int kRing = 8;         // rows kept, a power of two that holds kBlurTaps + 1
constexpr int kLine = 16;        // floats in a cache line
constexpr int kFloatSlack = 32;  // what vector code may overrun
// Columns that are blurred together. 2000 features want about half of all such blocks on TUM and KITTI images.
constexpr int kBlock = 32;
constexpr int kRowsAhead = 8;  // prefetched: the processor does not predict narrow runs of a large image

size_t strideOf(int width) { return (width + 2 * kFloatSlack + kLine - 1) / kLine * kLine; }

int reflect(int i, int size) { return i < 0 ? -i : i >= size ? 2 * size - 2 - i : i; }
}  // namespace

void Blur::reserve(int width) {
  const size_t floats = (kRing + 2) * strideOf(width) + kLine;
  if (storage_.size() < floats) storage_.resize(floats);
  wanted_down_to_.reserve((width + kBlock - 1) / kBlock);
  runs_.reserve(wanted_down_to_.capacity());
}

void Blur::collectRuns(int y, int width) {
  runs_.clear();
  const int blocks = static_cast<int>(wanted_down_to_.size());
  for (int block = 0; block < blocks; ++block) {
    if (wanted_down_to_[block] < y) continue;
    const int first = block * kBlock;
    while (block < blocks && wanted_down_to_[block] >= y) ++block;
    runs_.push_back({first, std::min(block * kBlock, width)});
  }
}

void Blur::apply(const Plane& source, const std::vector<Corner>& corners, const FeatureKernels& kernels,
                 Plane& target) {
  const int width = source.width(), height = source.height();
  target.resize(width, height);
  reserve(width);
  const size_t stride = strideOf(width);
  const auto address = reinterpret_cast<uintptr_t>(storage_.data()) / sizeof(float);
  float* first = storage_.data() + (kLine - address % kLine) % kLine;
  float* const pixels[2] = {first + kFloatSlack, first + stride + kFloatSlack};
  float* ring = first + 2 * stride;
  const auto ringRow = [&](int y) { return ring + (reflect(y, height) % kRing) * stride; };
  // Converts the pixels of a run and kBlurRadius more on either side.
  const auto widen = [&](int y, const Run& run, float* row) {
    const int begin = std::max(0, run.first - kBlurRadius), end = std::min(width, run.last + kBlurRadius);
    kernels.widenRow(source.row(y) + begin, end - begin, row + begin);
    for (int i = 1; run.first == 0 && i <= kBlurRadius; ++i) row[-i] = row[i];
    for (int i = 1; end == width && i <= kBlurRadius; ++i) row[width - 1 + i] = row[width - 1 - i];
  };
  const auto fetch = [&](int y, const Run& run) {
    constexpr int kCacheLine = 64;
    for (int x = run.first - kBlurRadius; x < run.last + kBlurRadius + kCacheLine; x += kCacheLine) {
      __builtin_prefetch(source.row(y) + x);
      __builtin_prefetch(target.row(y) + x, 1);
    }
  };

  wanted_down_to_.assign((width + kBlock - 1) / kBlock, -kBlurTaps);
  auto corner = corners.begin();
  // Two rows at a time, from above the image: row 0 needs the filtered rows 0 to 3.
  for (int step = -kBlurRadius - 1; step < height; step += 2) {
    const int y = std::min(step, height - 2);
    // The new filtered rows, y + 3 and y + 4, serve the blurred rows down to y + 7.
    for (; corner != corners.end() && corner->y - kDescriptorRadius <= y + kBlurTaps; ++corner) {
      const int last = (corner->x + kDescriptorRadius) / kBlock;
      for (int block = (corner->x - kDescriptorRadius) / kBlock; block <= last; ++block) {
        wanted_down_to_[block] = corner->y + kDescriptorRadius;
      }
    }
    collectRuns(y, width);
    // All pixels first: reading them back at once, at other offsets, would wait for the stores.
    for (const Run& run : runs_) {
      for (int k = 0; k < 2; ++k) {
        widen(reflect(y + kBlurRadius + k, height), run, pixels[k]);
        fetch(std::min(y + k + kRowsAhead, height - 1), run);
      }
    }
    float* ring_rows[kBlurTaps + 1];
    for (int k = 0; k <= kBlurTaps; ++k) ring_rows[k] = ringRow(y + k - kBlurRadius);
    uint8_t* const target_rows[2] = {target.row(std::max(y, 0)), target.row(std::max(y, 0) + 1)};
    for (const Run& run : runs_) {
      float* rows[kBlurTaps + 1];
      for (int k = 0; k <= kBlurTaps; ++k) rows[k] = ring_rows[k] + run.first;
      const float* const starts[2] = {pixels[0] + run.first, pixels[1] + run.first};
      uint8_t* const targets[2] = {target_rows[0] + run.first, target_rows[1] + run.first};
      kernels.blurTwoRows(starts, rows, run.last - run.first, targets);
    }
  }
}

}  // namespace gms_ransac
