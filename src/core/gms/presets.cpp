#include "gms/presets.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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

Acceptance parseAcceptance(const std::string& name) {
  if (name == "own") return Acceptance::kMethodsOwn;
  if (name == "threshold") return Acceptance::kThreshold;
  if (name == "evidence") return Acceptance::kEvidence;
  throw std::invalid_argument("unknown acceptance '" + name + "'; known are own, threshold, evidence");
}

MotionStatisticsOptions MotionStatisticsOptions::methodsOwn() {
  MotionStatisticsOptions options;
  options.grid_columns = options.grid_rows = 0;
  options.threshold_factor = 0;
  options.acceptance = Acceptance::kMethodsOwn;
  return options;
}

namespace {

/// Fills in what is left open once it is known what makes a match accepted.
MotionStatisticsOptions complete(MotionStatisticsOptions given, Acceptance own) {
  if (given.acceptance == Acceptance::kMethodsOwn) given.acceptance = own;
  const bool weighs = given.acceptance == Acceptance::kEvidence;
  if (given.threshold_factor == 0) given.threshold_factor = weighs ? kEvidenceThresholdFactor : kPaperThresholdFactor;
  if (!weighs && given.grid_columns == 0 && given.grid_rows == 0) given.grid_columns = given.grid_rows = kPaperGrid;
  return given;
}

}  // namespace

MotionStatisticsOptions publishedSettings(MotionStatisticsOptions given, GridNeighborhood neighborhood) {
  given = complete(given, Acceptance::kThreshold);
  if (neighborhood == GridNeighborhood::kFive) given.neighborhood = neighborhood;
  return given;
}

MotionStatisticsOptions evidenceSettings(MotionStatisticsOptions given) {
  return complete(given, Acceptance::kEvidence);
}

CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches) {
  CellGrid grid = {options.grid_columns, options.grid_rows};
  const double width = std::max(image.width, 1), height = std::max(image.height, 1);
  const double cells = std::min(std::max(matches / kMatchesPerCell, 1.0), kMostCells);
  double side = std::sqrt(width * height / cells);  // of a cell, pixels
  if (grid.rows > 0) side = height / grid.rows;
  if (grid.columns > 0) side = width / grid.columns;
  if (grid.columns == 0) grid.columns = automaticSide(width / side);
  if (grid.rows == 0) grid.rows = automaticSide(height / side);
  return grid;
}

}  // namespace gms_ransac
