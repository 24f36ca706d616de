// Arithmetic on a few matches at a time with what every processor has, so that what is summed once for each pair needs
// no kernel for each instruction set and returns the same bits under all of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>

#include <Eigen/Core>

#include "two_view/kernels/point_columns.h"

namespace gms_ransac {

constexpr int kLanesAtOnce = 4;  ///< divides the columns of PointColumnsView
using Lanes = Eigen::Array<float, kLanesAtOnce, 1>;

inline Eigen::Map<const Lanes> lanes(const float* first) { return Eigen::Map<const Lanes>(first); }
inline Eigen::Map<Lanes> lanes(float* first) { return Eigen::Map<Lanes>(first); }

/// A vector of three coordinates of each match.
struct VectorLanes {
  Lanes x, y, z;

  VectorLanes() = default;
  VectorLanes(const Lanes& x, const Lanes& y, const Lanes& z) : x(x), y(y), z(z) {}
  /// The same for all.
  explicit VectorLanes(const Eigen::Vector3f& v)
      : x(Lanes::Constant(v.x())), y(Lanes::Constant(v.y())), z(Lanes::Constant(v.z())) {}
  /// The rays of points of the normalised image plane.
  VectorLanes(const float* columns_x, const float* columns_y)
      : x(lanes(columns_x)), y(lanes(columns_y)), z(Lanes::Ones()) {}
};

inline VectorLanes operator-(const VectorLanes& a, const VectorLanes& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline VectorLanes operator*(const Lanes& s, const VectorLanes& v) { return {s * v.x, s * v.y, s * v.z}; }
inline VectorLanes operator*(const Eigen::Matrix3f& M, const VectorLanes& v) {
  return {M(0, 0) * v.x + M(0, 1) * v.y + M(0, 2) * v.z, M(1, 0) * v.x + M(1, 1) * v.y + M(1, 2) * v.z,
          M(2, 0) * v.x + M(2, 1) * v.y + M(2, 2) * v.z};
}
inline VectorLanes cross(const VectorLanes& a, const VectorLanes& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Lanes dot(const VectorLanes& a, const VectorLanes& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Sums of the products of `P` columns with each other, of `size` rows (a multiple of kLanesAtOnce) and `stride` apart.
/// Blocks are summed as T, their sums in double. By tiles of columns: what is loaded is used more than once.
template <int P, class T>
Eigen::Matrix<double, P, P> sumProducts(const T* columns, int stride, int size) {
  constexpr int kBlock = 4 * kLanes, kTile = 3;
  static_assert(P % kTile == 0, "whole tiles");
  using Entries = Eigen::Array<T, kLanesAtOnce, 1>;
  const auto entries = [&](int column, int row) {
    return Eigen::Map<const Entries>(columns + static_cast<ptrdiff_t>(column) * stride + row);
  };
  Eigen::Matrix<double, P, P> sums = Eigen::Matrix<double, P, P>::Zero();
  const auto addTile = [&](int k, int l, int first, int end) {
    Entries tile[kTile][kTile];
    for (auto& row : tile) std::fill(std::begin(row), std::end(row), Entries::Zero());
    for (int i = first; i < end; i += kLanesAtOnce) {
      const Entries left[kTile] = {entries(k, i), entries(k + 1, i), entries(k + 2, i)};
      for (int b = 0; b < kTile; ++b) {
        const Entries right = entries(l + b, i);
        for (int a = 0; a < kTile; ++a) tile[a][b] += left[a] * right;
      }
    }
    for (int a = 0; a < kTile; ++a) {
      for (int b = 0; b < kTile; ++b) sums(k + a, l + b) += static_cast<double>(tile[a][b].sum());
    }
  };
  for (int first = 0; first < size; first += kBlock) {
    const int end = std::min(first + kBlock, size);
    for (int k = 0; k < P; k += kTile) {
      for (int l = 0; l <= k; l += kTile) addTile(k, l, first, end);
    }
  }
  sums.template triangularView<Eigen::StrictlyUpper>() = sums.transpose();
  return sums;
}

}  // namespace gms_ransac
