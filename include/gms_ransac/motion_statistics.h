// Third stage, matches -> motion statistics: Grid-based Motion Statistics (Bian et al., CVPR 2017).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

/// The published implementations differ where a shifted grid leaves the image at the left or top, and in rounding the
/// sides of a scaled grid.
enum class GridBorder {
  kOriginal,  ///< Bian's: the half cells at the left and the top take no part in a shifted grid; sides truncated
  kOpencv     ///< xfeatures2d: they form cells of their own; sides rounded
};
enum class GridNeighborhood { kNine, kFive };  ///< 3x3 cells (Bian 2017) or centre + N/E/S/W (Chen 2018)

enum class Criterion {
  kThreshold,  ///< as published: the score of the cell pair reaches the threshold
  kEvidence    ///< ours: also likely to be right by descriptors, rotation and change of octave
};

/// Readings of the second filter of Zhu et al. 2019, whose criterion the paper does not print.
enum class DistanceReading {
  /// The length of the displacement is within 3 robust standard deviations (1.4826 MAD), at least 3 px, of the median
  /// over the 3 x 3 reference cells around it.
  kDisplacement,
  /// The median ratio of distances to 8 random partners, after over before, is within 20 % of the median of all
  /// matches.
  kPairwise
};

struct MotionStatisticsOptions {
  std::optional<Criterion> criterion;  ///< not set: the method's own; of a filter by itself kThreshold
  /// Cells across and down the reference image. Neither: 20 x 20, with kEvidence square cells; one: square cells.
  std::optional<int> grid_columns, grid_rows;
  /// Alpha of the paper, for nine cells; with five sqrt(5/9) of it is used. Not set: 6 as published, 1 with kEvidence.
  std::optional<double> threshold_factor;
  bool rotation = false;  ///< try all rotations of the neighbourhood, not only the identity
  bool scale = false;     ///< try right grids of 1/2, 1/sqrt2, sqrt2, 2 times the cells, not only 1
  GridBorder border = GridBorder::kOpencv;
  GridNeighborhood neighborhood = GridNeighborhood::kNine;

  void validate() const;
};

/// One entry per raw match, in the order given.
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

  /// Any number of matches; keypoints outside their image take no part. Bit-exact with the published algorithm: the
  /// (scale, rotation) with the most accepted matches wins, the first of equals. No allocation once warm.
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
