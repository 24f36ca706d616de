// Options of the pipeline.
#pragma once

#include <optional>
#include <string>

#include "gms_ransac/feature_extractor.h"
#include "gms_ransac/motion_statistics.h"
#include "gms_ransac/robust_options.h"

namespace gms_ransac {

/// The current descriptors that each reference descriptor is compared with.
enum class SearchMode {
  kFull,   ///< all
  kGuided  ///< those near where its surroundings moved; all where that is not known
};

struct MatchFilterOptions {
  std::string method = "lo_prosac";
  FeatureExtractorOptions extractor;
  MotionStatisticsOptions motion_statistics;
  RobustOptions robust;
  int matcher_threads = 1;
  SearchMode search = SearchMode::kGuided;  ///< always full for methods that want mutual neighbours or are GMS alone
  DistanceReading distance_reading = DistanceReading::kDisplacement;  ///< gms_dist_ransac
  /// Of matches that share a current point only the best goes on to the estimator: the likeliest where the filter
  /// weighs evidence, else that of least descriptor distance. Off: as in the papers.
  bool one_to_one = true;
  /// Move some points of every part of the current image to where it shows what the reference shows, to a tenth of a
  /// pixel. Needs images; those of the caller's features have none.
  bool align_points = true;
  bool lan_mutual = true;  ///< lan: match in both directions; false: feed it the same matches as the other methods
  /// lan: threshold factor of the final check; not set: the first times the square root of the share kept.
  std::optional<double> lan_second_threshold_factor;

  /// Time for an image; fewer features, samples and refinement steps are used so that 99 % of the images keep it. 0: no
  /// limit, and results do not depend on the machine.
  double max_milliseconds = 0;

  void validate() const;

  /// The paper's settings: cv::ORB, GMS matches sorted by score, ratio 1/2, no refinement (cfg/paper.yaml).
  static MatchFilterOptions paper();
};

}  // namespace gms_ransac
