#include "features/blur.h"

#include <algorithm>

namespace gms_ransac {

namespace {
constexpr int kRing = 8;         // rows kept, a power of two that holds kBlurTaps + 1
constexpr int kLine = 16;        // floats in a cache line
constexpr int kFloatSlack = 32;  // what vector code may overrun
// Columns that are blurred together. 2000 features want about half of all such blocks on TUM and KITTI images.
constexpr int kBlock = 32;

/// Floats from one row to the next.
size_t strideOf(int width) { return (width + 2 * kFloatSlack + kLine - 1) / kLine * kLine; }

int reflect(int i, int size) { return i < 0 ? -i : i >= size ? 2 * size - 2 - i : i; }
}  // namespace

void Blur::reserve(int width) {
  const size_t floats = (kRing + 2) * strideOf(width) + kLine;
  if (storage_.size() < floats) storage_.resize(floats);
  wanted_down_to_.reserve((width + kBlock - 1) / kBlock);
  runs_.reserve(wanted_down_to_.capacity());
}

void Blur::want(const Corner& corner) {
  const int last = (corner.x + kDescriptorRadius) / kBlock;
  for (int block = (corner.x - kDescriptorRadius) / kBlock; block <= last; ++block) {
    wanted_down_to_[block] = corner.y + kDescriptorRadius;
  }
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
  /// The pixels of a run and kBlurRadius more on either side.
  const auto widen = [&](int y, const Run& run, float* row) {
    const int begin = std::max(0, run.first - kBlurRadius), end = std::min(width, run.last + kBlurRadius);
    kernels.widenRow(source.row(y) + begin, end - begin, row + begin);
    for (int i = 1; run.first == 0 && i <= kBlurRadius; ++i) row[-i] = row[i];
    // A run that ends just before the side looks beyond it too.
    for (int i = 1; end == width && i <= kBlurRadius; ++i) row[width - 1 + i] = row[width - 1 - i];
  };
  const auto filterRow = [&](int y) {
    widen(y, {0, width}, pixels[0]);
    kernels.blurRow(pixels[0], width, ringRow(y));
  };

  wanted_down_to_.assign((width + kBlock - 1) / kBlock, -1);
  auto corner = corners.begin();
  for (int y = 0; y < kBlurRadius; ++y) filterRow(y);
  int y = 0;
  for (; y + kBlurRadius + 1 < height; y += 2) {
    // The new filtered rows, y + 3 and y + 4, serve the blurred rows down to y + 7.
    const int reach = y + kBlurTaps;
    for (; corner != corners.end() && corner->y - kDescriptorRadius <= reach; ++corner) want(*corner);
    collectRuns(y, width);
    // First all of the pixels: reading them back at once, at other offsets, would wait for the stores.
    for (const Run& run : runs_) {
      for (int k = 0; k < 2; ++k) widen(y + kBlurRadius + k, run, pixels[k]);
    }
    float* ring_rows[kBlurTaps + 1];
    for (int k = 0; k <= kBlurTaps; ++k) ring_rows[k] = ringRow(y + k - kBlurRadius);
    for (const Run& run : runs_) {
      float* rows[kBlurTaps + 1];
      for (int k = 0; k <= kBlurTaps; ++k) rows[k] = ring_rows[k] + run.first;
      const float* const starts[2] = {pixels[0] + run.first, pixels[1] + run.first};
      uint8_t* const targets[2] = {target.row(y) + run.first, target.row(y + 1) + run.first};
      kernels.blurTwoRows(starts, rows, run.last - run.first, targets);
    }
  }
  for (; y < height; ++y) {
    if (y + kBlurRadius < height) filterRow(y + kBlurRadius);
    const float* rows[kBlurTaps];
    for (int k = 0; k < kBlurTaps; ++k) rows[k] = ringRow(y + k - kBlurRadius);
    kernels.blurColumns(rows, width, target.row(y));
  }
}

}  // namespace gms_ransac
