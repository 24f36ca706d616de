// The matches as the SIMD kernels read them: aligned columns of float, padded to whole blocks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace gms_ransac {

/// Lanes of one step of a kernel. Every instruction set adds this many partial sums in one order, so that all return
/// the same bits.
constexpr int kLanes = 16;

/// Input of a kernel. `size` is a multiple of kLanes; entries past `count` have weight and residual 0.
struct PointColumnsView {
  const float *x1, *y1, *x2, *y2;  ///< reference (1) and current (2) point, working coordinates
  const float* weight;             ///< 1 / squared threshold of the point, so that a residual of 1 is at the threshold
  int size = 0, count = 0;
  int64_t* evaluations = nullptr;  ///< raised by every residual that a model computes; null: not counted

  void countPasses(int passes) const { countResiduals(static_cast<int64_t>(count) * passes); }
  void countResiduals(int64_t residuals) const {
    if (evaluations != nullptr) *evaluations += residuals;
  }
};

/// Slots that suffice for a first look at a motion: a random part of the matches.
constexpr int kRandomPart = 256;

/// The first slots, as many as `count` (a multiple of kLanes) or all.
inline PointColumnsView firstSlots(PointColumnsView points, int count) {
  if (points.count > count) points.size = points.count = count;
  return points;
}

/// A pseudo-random order of `count` rows: every n-th, n about 0.618 of the count and coprime with it.
inline void strideOver(int count, std::vector<int>& row_of) {
  int stride = std::max(1, static_cast<int>(0.618 * count));
  while (std::gcd(count, stride) != 1) ++stride;
  row_of.resize(static_cast<size_t>(count));
  int row = 0;
  for (int& entry : row_of) {
    entry = row;
    row += stride;
    if (row >= count) row -= count;
  }
}

/// Columns of floats, each aligned as the kernels ask for. Keeps its storage.
class AlignedColumns {
 public:
  void resize(int columns, int count) {
    blocks_ = (count + kLanes - 1) / kLanes;
    storage_.resize(std::max(storage_.size(), static_cast<size_t>(columns) * blocks_ + 1));
  }
  /// Entries of a column: a multiple of kLanes.
  int size() const { return blocks_ * kLanes; }
  float* column(int k) { return storage_[static_cast<size_t>(k) * blocks_].lane; }
  const float* column(int k) const { return storage_[static_cast<size_t>(k) * blocks_].lane; }

 private:
  struct alignas(kLanes * sizeof(float)) Block {
    float lane[kLanes];
  };
  std::vector<Block> storage_;
  int blocks_ = 0;
};

class PointColumns {
 public:
  void resize(int count) {
    columns_.resize(5, count);
    count_ = count;
    for (int c = 0; c < 5; ++c) std::fill(column(c) + count, column(c) + columns_.size(), 0.f);
  }
  void gather(const PointColumnsView& from, const int* slots, int count) {
    resize(count);
    countInto(from.evaluations);
    const float* sources[] = {from.x1, from.y1, from.x2, from.y2, from.weight};
    for (int c = 0; c < 5; ++c) {
      for (int i = 0; i < count; ++i) column(c)[i] = sources[c][slots[i]];
    }
  }
  /// Copies all slots of others; one for which keep(slot) is false gets no weight.
  template <class Keep>
  void copy(const PointColumnsView& from, const Keep& keep) {
    resize(from.count);
    countInto(from.evaluations);
    const float* sources[] = {from.x1, from.y1, from.x2, from.y2, from.weight};
    for (int c = 0; c < 5; ++c) std::copy_n(sources[c], from.count, column(c));
    for (int slot = 0; slot < from.count; ++slot) {
      if (!keep(slot)) column(4)[slot] = 0;
    }
  }
  float* x1() { return column(0); }
  float* y1() { return column(1); }
  float* x2() { return column(2); }
  float* y2() { return column(3); }
  float* weight() { return column(4); }
  int count() const { return count_; }
  /// Where what is computed of these columns is counted; it must outlive their views.
  void countInto(int64_t* evaluations) { evaluations_ = evaluations; }
  PointColumnsView view() const {
    const AlignedColumns& c = columns_;
    return {c.column(0), c.column(1), c.column(2), c.column(3), c.column(4), c.size(), count_, evaluations_};
  }

 private:
  float* column(int c) { return columns_.column(c); }

  AlignedColumns columns_;
  int count_ = 0;
  int64_t* evaluations_ = nullptr;
};

}  // namespace gms_ransac
