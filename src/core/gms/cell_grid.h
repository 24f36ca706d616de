// Grids of cells with one empty cell around them, so that a neighbour can be looked up without a test.
#pragma once

#include <array>

#include <opencv2/core/types.hpp>

#include "gms_ransac/motion_statistics.h"

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

/// The eight neighbours of a cell, clockwise; one position is 45 degrees.
constexpr std::array<int, 8> kRingColumn = {-1, 0, 1, 1, 1, 0, -1, -1};
constexpr std::array<int, 8> kRingRow = {-1, -1, -1, 0, 1, 1, 1, 0};

/// The four grids of one run: the plain one, and shifted by half a cell in x, in y, in both.
constexpr int kShifts = 4;
constexpr int shiftX(int shift) { return shift & 1; }
constexpr int shiftY(int shift) { return shift >> 1; }

/// Fills in all but the grid: Bian's settings (20 x 20 cells, 6) or the measured ones for evidence (square cells, 1).
MotionStatisticsOptions withDefaults(MotionStatisticsOptions given, Criterion own = Criterion::kThreshold);

/// The grid of the options, or square cells that hold kMatchesPerCell voting matches.
CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches);

}  // namespace gms_ransac
