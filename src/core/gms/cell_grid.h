// Grids of cells with one empty cell around them, so that a neighbour can be looked up without a test.
#pragma once

#include <array>

namespace gms_ransac {

/// `columns` x `rows` cells inside a border of one; cells are numbered row by row, the border included.
struct CellGrid {
  int columns = 0, rows = 0;

  int stride() const { return columns + 2; }
  int size() const { return stride() * (rows + 2); }
  int index(int column, int row) const { return (row + 1) * stride() + column + 1; }
  int firstCell() const { return stride() + 1; }         ///< the first cell inside the border
  int endCell() const { return size() - stride() - 1; }  ///< one past the last one; some border cells lie between
  bool contains(int cell) const {
    const int column = cell % stride() - 1, row = cell / stride() - 1;
    return column >= 0 && column < columns && row >= 0 && row < rows;
  }
  bool operator==(const CellGrid& other) const { return columns == other.columns && rows == other.rows; }
};

/// The eight neighbours clockwise, starting at the upper left.
constexpr std::array<int, 8> kRingColumn = {-1, 0, 1, 1, 1, 0, -1, -1};
constexpr std::array<int, 8> kRingRow = {-1, -1, -1, 0, 1, 1, 1, 0};

/// Ring position in the right image of the neighbour at position `k` of the left one, `turns` steps of 45 degrees.
constexpr int turnedRing(int k, int turns) { return (k - turns) & 7; }

/// The four grids of one run: the plain one, and shifted by half a cell in x, in y, in both.
constexpr int kShifts = 4;
constexpr int shiftX(int shift) { return shift & 1; }
constexpr int shiftY(int shift) { return shift >> 1; }

}  // namespace gms_ransac
