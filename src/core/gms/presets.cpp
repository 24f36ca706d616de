#include "gms/presets.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

// Bian 2017.
constexpr int kPaperGrid = 20;
constexpr double kPaperThresholdFactor = 6.0;

// Measured at 2000 features on kitti_06 (gaps 1, 5, 10), tum_fr1_desk (1, 4), tum_fr1_rpy (1, 5) and
// 7scenes_redkitchen (25), with cells of 2, 4 and 6 matches: doc/motion_statistics.md has the tables. 6 gives the best
// poses where matches are few, and costs nothing elsewhere. The threshold only spares what nobody votes for.
constexpr double kMatchesPerCell = 6.0;
constexpr double kEvidenceThresholdFactor = 1.0;
constexpr double kMostCells = 400;  ///< as in the paper; with more, the vote matrix leaves the cache
constexpr int kFewestOnSide = 4, kMostOnSide = 100;

int automaticSide(double cells) {
  return std::min(std::max(static_cast<int>(std::lround(cells)), kFewestOnSide), kMostOnSide);
}

}  // namespace

MotionStatisticsOptions withDefaults(MotionStatisticsOptions given, Criterion own) {
  given.criterion = given.criterion.value_or(own);
  const bool weighs = given.criterion == Criterion::kEvidence;
  given.threshold_factor = given.threshold_factor.value_or(weighs ? kEvidenceThresholdFactor : kPaperThresholdFactor);
  if (!weighs && !given.grid_columns && !given.grid_rows) given.grid_columns = given.grid_rows = kPaperGrid;
  return given;
}

CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches) {
  const double width = std::max(image.width, 1), height = std::max(image.height, 1);
  const double cells = std::min(std::max(matches / kMatchesPerCell, 1.0), kMostCells);
  double side = std::sqrt(width * height / cells);  // of a cell, pixels
  if (options.grid_rows) side = height / *options.grid_rows;
  if (options.grid_columns) side = width / *options.grid_columns;
  return {options.grid_columns.value_or(automaticSide(width / side)),
          options.grid_rows.value_or(automaticSide(height / side))};
}

}  // namespace gms_ransac
