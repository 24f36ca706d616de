// PatchKernels::sumRows, in whole numbers. Included by patch_kernels_impl.h.
#pragma once

#include <algorithm>
#include <cstring>
#include <numeric>

#include "matching/patch_kernels.h"

namespace gms_ransac {
namespace {

// The rows of a patch lie kRowPixels apart, with room to shift it.
constexpr int kLevels = kRowPixels * kRowPatchHeight;

/// Grey levels, or what is computed of them, in the rows of a patch.
struct Levels {
  int16_t at[kLevels + kRowShifts] = {};

  Levels() = default;
  explicit Levels(const PixelRows& rows) {
    uint8_t bytes[kLevels];
    read(rows, kRowPatchHeight, bytes);
    for (int i = 0; i < kLevels; ++i) at[i] = bytes[i];
  }
  /// Lower by `below` of kWholeRow.
  Levels(const PixelRows& rows, uint16_t below) {
    uint8_t bytes[kLevels + kRowPixels] = {};
    read(rows, kRowPatchHeight + (below > 0), bytes);
    const auto above = static_cast<uint16_t>(kWholeRow - below);
    for (int i = 0; i < kLevels; ++i) {  // 16 bits hold the sum
      const auto sum = static_cast<uint16_t>(bytes[i] * above + bytes[i + kRowPixels] * below + kWholeRow / 2);
      at[i] = static_cast<int16_t>(sum / kWholeRow);
    }
  }

 private:
  static void read(const PixelRows& rows, int count, uint8_t* bytes) {
    for (int v = 0; v < count; ++v) std::memcpy(bytes + v * kRowPixels, rows.first + v * rows.stride, kRowPixels);
  }
};

/// The columns of the patch that begins at `levels`; zero in the others.
inline Levels inPatch(const int16_t* levels) {
  Levels patch;
  for (int v = 0; v < kRowPatchHeight; ++v)
    std::copy_n(levels + v * kRowPixels, kRowPatchWidth, patch.at + v * kRowPixels);
  return patch;
}

inline int sumOfProducts(const int16_t* a, const int16_t* b) {
  int sum = 0;
  for (int i = 0; i < kLevels; ++i) sum += a[i] * b[i];
  return sum;
}

/// Sums of the patch's columns.
struct ColumnSums {
  int16_t at[kRowPixels] = {};

  explicit ColumnSums(const Levels& levels) {
    for (int v = 0; v < kRowPatchHeight; ++v) {
      for (int x = 0; x < kRowPixels; ++x) at[x] = static_cast<int16_t>(at[x] + levels.at[v * kRowPixels + x]);
    }
  }
  int from(int shift) const { return std::accumulate(at + shift, at + shift + kRowPatchWidth, 0); }
};

RowSums sumRows(const PixelRows& left, const PixelRows& right, uint16_t below) {
  const Levels around(left), there(right, below);
  Levels gradient;
  for (int i = 0; i < kLevels; ++i) gradient.at[i] = static_cast<int16_t>(around.at[i + 2] - around.at[i]);
  gradient = inPatch(gradient.at);
  const Levels own = inPatch(around.at + 1), middle = inPatch(there.at + kRowShifts / 2);
  RowSums sums = {};
  sums.gradient = ColumnSums(gradient).from(0);
  sums.own = ColumnSums(own).from(0);
  sums.gradient_gradient = sumOfProducts(gradient.at, gradient.at);
  sums.own_own = sumOfProducts(own.at, own.at);
  sums.middle_middle = sumOfProducts(middle.at, middle.at);
  sums.gradient_own = sumOfProducts(gradient.at, own.at);
  const ColumnSums there_sums(there);
  for (int k = 0; k < kRowShifts; ++k) {
    sums.there[k] = there_sums.from(k);
    sums.gradient_there[k] = sumOfProducts(gradient.at, there.at + k);
  }
  return sums;
}

}  // namespace
}  // namespace gms_ransac
