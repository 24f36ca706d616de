// The result of one pair of images.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_result.h"

namespace gms_ransac {

/// Outcome of one pair. Values are those of gms_ransac/MatchStats.
enum class Status : uint8_t {
  kOk = 0,
  kFirstFrame = 1,       ///< nothing to compare with yet
  kTooFewKeypoints = 2,  ///< fewer than kMinimumMatches in one of the images
  kTooFewMatches = 3,    ///< fewer than kMinimumMatches raw matches
  kGmsRejected = 4,      ///< fewer than kMinimumMatches left by the filter
  kRansacFailed = 5,     ///< no model that explains at least kMinimumMatches of the matches
  kLowParallax = 6,      ///< rotation is good, the direction of translation is not observable
  kUncalibrated = 7      ///< correspondences only, no pose
};
std::string toString(Status status);  ///< "OK", "FIRST_FRAME", ...

constexpr int kMinimumMatches = 8;

enum class MatchStage : uint8_t { kRaw = 0, kGms = 1, kInlier = 2 };

struct StageTimes {
  double detect = 0, match = 0, gms = 0, ransac = 0;  ///< seconds; detect is the current image alone
  double total() const { return detect + match + gms + ransac; }
};

/// The matches that the filter keeps, for the estimator.
struct Survivors {
  std::vector<int> match;  ///< indices into the raw matches, ascending
  PointPairs pairs;        ///< one for each `match`

  int size() const { return static_cast<int>(match.size()); }
};

/// The status of an estimate with this camera.
Status statusOf(const RobustResult& result, const Camera& camera);

/// The result of one pair. `matches` holds every raw match; each column has one entry per match.
struct MatchResult {
  Status status = Status::kFirstFrame;
  int keypoints_reference = 0, keypoints_current = 0;
  std::vector<Match> matches;
  std::vector<MatchStage> stage;
  /// 0..1: motion-statistics score over the largest score of the pair; 1 where the method has no such scores.
  std::vector<float> confidence;
  /// 0..1, that the match is right; 0 where not known: rejected by the filter, or no model.
  std::vector<float> probability;
  int matches_gms = 0, inliers = 0;
  Survivors survivors;
  bool stationary = false;  ///< the camera stands still: what is static moved less than its noise
  RobustResult robust;      ///< columns have an entry per survivor; `stage` and `probability` are for the raw matches
  StageTimes times;

  void clear(Status new_status);
};

}  // namespace gms_ransac
