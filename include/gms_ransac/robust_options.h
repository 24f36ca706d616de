// Options of the robust estimation of model and pose.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gms_ransac/shutter.h"
#include "gms_ransac/simd.h"

namespace gms_ransac {

enum class ModelType { kEssential, kFundamental, kHomography };

/// "essential", "fundamental", "homography"; throws std::invalid_argument for another word.
ModelType parseModelType(const std::string& name);
std::string toString(ModelType model);

/// Confidence of a match. Ties: score, distance, Lowe ratio, index.
enum class SortKey {
  kScore,          ///< motion statistics: matches in support of it in the neighbourhood
  kRelativeScore,  ///< score over the threshold of its neighbourhood, which takes out the density of the texture
  kDistance,       ///< Hamming distance
  kLoweRatio,      ///< distance over second-nearest distance, in steps of 1/511
};

struct RobustOptions {
  ModelType model = ModelType::kEssential;
  std::optional<double> inlier_threshold_px;  ///< not set: 1 for essential and fundamental, 3 for homography
  double success_probability = 0.99;          ///< of having drawn a sample without outliers
  int max_iterations = 2000;                  ///< cap on samples
  uint64_t seed = 0;                          ///< same seed, same result
  double first_group_fraction =
      0.5;                        ///< cp_ransac: share of the matches in the first confidence group, the paper's ratio
  bool geometric_groups = false;  ///< cp_ransac: every further group that share of the rest, instead of one of all
  int tdd_d = 1;                  ///< rransac_tdd: matches tested before a full verification
  int subset_count = 5;           ///< subset_ransac: random subsets
  double subset_fraction = 0.2;   ///< subset_ransac: share of the matches in each
  double split_fraction = 0.2;    ///< split2080: share of the matches that are sampled; 1: all, and all verify
  std::optional<double> target_inlier_ratio;  ///< gms_ransac: stop at this inlier ratio
  std::optional<SortKey> sort_key;            ///< of methods that order the matches; not set: the method's own
  /// Check inlier count and spread, parallax and alternative models. Off: the model stands, as in the papers.
  bool judge = true;
  double min_pose_probability = 0.865;      ///< with less the direction of translation is not published
  double min_rotation_probability = 0.805;  ///< with less the rotation is not published
  /// Standard deviation of the direction, degrees, (0, 90], along its widest axis, that the pose is judged against.
  double max_direction_sigma = 10;
  double calibration_sigma = 0;  ///< relative uncertainty of the focal length, and of the principal point in focal
                                 ///< lengths: widens the covariance
  /// Seconds from the first row of an image to the last. Above 0: a rolling shutter, and points are moved to where the
  /// camera saw them when it read the middle row. 0: a global shutter. Below 0: unknown, until the stream shows it; an
  /// answer that a rolling shutter would explain as well is not OK before it has shown that there is none.
  double rolling_shutter_readout = -1;
  /// Robust least squares on the matches near the best model. `lo_prosac` always does.
  bool refine = true;
  SimdLevel simd = detectSimdLevel();

  bool mayRoll(const Shutter& of_stream) const {
    return rolling_shutter_readout > 0 || (rolling_shutter_readout < 0 && of_stream.kind != Shutter::kGlobal);
  }
  double inlierThreshold() const { return inlier_threshold_px.value_or(model == ModelType::kHomography ? 3.0 : 1.0); }
  void validate() const;
};

}  // namespace gms_ransac
