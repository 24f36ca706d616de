// Third stage, matches -> motion statistics: Grid-based Motion Statistics (Bian et al., CVPR 2017).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

/// The two published implementations differ where a shifted grid leaves the image at the left or the top, and in how
/// the sides of a scaled right grid become whole numbers.
enum class GridBorder {
  kOriginal,  ///< Bian's: the half cells at the left and the top take no part in a shifted grid; sides truncated
  kOpenCV     ///< xfeatures2d: they form cells of their own; sides rounded
};
enum class GridNeighborhood { kNine, kFive };  ///< 3x3 cells (Bian 2017) or centre + N/E/S/W (Chen 2018)
enum class FiveCellFactor {
  kScaled,  ///< threshold_factor is the nine-cell one; sqrt(5/9) of it is used with five cells
  kRaw      ///< threshold_factor is used as it is
};

enum class Acceptance {
  kMethodsOwn,  ///< for MatchFilterOptions only
  kThreshold,   ///< as published: the score of the cell pair reaches the threshold
  kEvidence     ///< ours: that, and descriptors, turn and change of octave make the match likely to be right
};

/// "own", "threshold", "evidence"; throws std::invalid_argument for another word.
Acceptance parseAcceptance(const std::string& name);

struct MotionStatisticsOptions {
  int grid_columns = 20;  ///< cells across the reference image, 2..100; 0: square cells, few where matches are few
  int grid_rows = 20;     ///< cells down the reference image, 2..100; 0: likewise
  double threshold_factor = 6.0;  ///< alpha of the paper, (0, 100]
  bool rotation = false;          ///< try all rotations of the neighbourhood, not only the identity
  bool scale = false;             ///< try right grids of 1/2, 1/sqrt2, sqrt2, 2 times the cells, not only 1
  GridBorder border = GridBorder::kOpenCV;
  GridNeighborhood neighborhood = GridNeighborhood::kNine;
  FiveCellFactor five_cell_factor = FiveCellFactor::kScaled;
  Acceptance acceptance = Acceptance::kThreshold;

  /// For MatchFilterOptions: leaves grid (0), threshold_factor (0) and acceptance to the method. The papers' methods
  /// have 20 x 20 cells, 6 and kThreshold, `lo_prosac` has square cells, 1 and kEvidence.
  static MotionStatisticsOptions methodsOwn();
  /// Throws std::invalid_argument with a sentence that names the field, its value and its range.
  void validate() const;
};

/// Per raw match, in the order given; columns have as many entries as there are matches.
struct MotionStatistics {
  std::vector<uint8_t> accepted;  ///< 1: some shifted grid accepts the match
  std::vector<int32_t> score;  ///< supporting matches in the neighbourhood, the largest over the shifts; 0 if rejected
  std::vector<float> relative_score;  ///< score / threshold of that same cell pair, >= 1; 0 if rejected
  std::vector<float> log_odds;  ///< that the match is right; of accepted ones, and with kEvidence only, else empty
  std::vector<int32_t> cell;    ///< cell of the reference keypoint in the unshifted grid, row * columns + column
  int accepted_count = 0;
  int grid_columns = 0, grid_rows = 0;  ///< the grid that was used
  int rotation = 0;                     ///< winning rotation pattern in steps of 45 degrees anticlockwise, 0..7
  int scale = 0;                        ///< winning right-grid scale, index into {1, 1/2, 1/sqrt2, sqrt2, 2}
};

class MotionStatisticsFilter {
 public:
  explicit MotionStatisticsFilter(const MotionStatisticsOptions& options = {});
  ~MotionStatisticsFilter();
  MotionStatisticsFilter(MotionStatisticsFilter&&) noexcept;
  MotionStatisticsFilter& operator=(MotionStatisticsFilter&&) noexcept;

  /// Any number of matches, including none; the images may differ in size. Reference keypoints outside their image
  /// take no part. Bit-exact with the published algorithm: the run (scale, rotation) with the most accepted matches
  /// wins, the first of equals. Reuses the storage of `statistics`; no allocation once warm.
  void compute(const Features& reference, const Features& current, const std::vector<Match>& matches,
               MotionStatistics& statistics);
  const MotionStatisticsOptions& options() const { return options_; }
  /// Replaces threshold_factor from the next call on; must be positive.
  void setThresholdFactor(double threshold_factor) { options_.threshold_factor = threshold_factor; }

 private:
  struct Workspace;
  MotionStatisticsOptions options_;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace gms_ransac
