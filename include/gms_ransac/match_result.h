// The result of one pair of images.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/learned_mask.h"
#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_result.h"

namespace gms_ransac {

/// Outcome of one pair. Values are those of gms_ransac/MatchStats; names and texts: status_text.cpp. A new one
/// is added here, to kStatuses, there, and to the message.
enum class Status : uint8_t {
  kOk = 0,
  kFirstFrame = 1,       ///< nothing to compare with yet
  kTooFewKeypoints = 2,  ///< fewer than kMinimumMatches in one of the images
  kTooFewMatches = 3,    ///< fewer than kMinimumMatches raw matches
  kGmsRejected = 4,      ///< fewer than kMinimumMatches left by the filter
  kRansacFailed = 5,     ///< no model that explains at least kMinimumMatches of the matches
  kLowParallax = 6,      ///< rotation is good, the direction of translation is not observable
  kUncalibrated = 7,     ///< correspondences only, no pose
  kMotionUnknown = 11    ///< a model explains the matches, but different rotations do as well: no pose
};
constexpr Status kStatuses[] = {
    Status::kOk,           Status::kFirstFrame,  Status::kTooFewKeypoints, Status::kTooFewMatches, Status::kGmsRejected,
    Status::kRansacFailed, Status::kLowParallax, Status::kUncalibrated,    Status::kMotionUnknown};
std::string toString(Status status);  ///< "OK", "FIRST_FRAME", ...: the names in MatchStats.msg

constexpr int kMinimumMatches = 8;

enum class MatchStage : uint8_t { kRaw = 0, kGms = 1, kInlier = 2 };

struct StageTimes {
  double detect = 0, match = 0, gms = 0, ransac = 0;  ///< seconds; detect is the current image alone
  double total() const { return detect + match + gms + ransac; }
};

/// The status of an estimate with this camera.
Status statusOf(const RobustResult& result, const Camera& camera);

/// The result of one pair. A match is a row: of `matches` and of every column, those of `pairs` and `robust` too.
struct MatchResult {
  Status status = Status::kFirstFrame;
  int keypoints_reference = 0, keypoints_current = 0;
  std::vector<Match> raw;      ///< all that were found, at most one for each reference keypoint
  std::vector<Match> matches;  ///< those that the filter keeps, in the order of `raw`
  PointPairs pairs;            ///< their points
  /// Pixels of the current image: the keypoints, moved where they are aligned.
  std::vector<cv::Point2f> current_pixel;
  /// 0..1: motion-statistics score over the largest score of the pair; 1 where the method has no such scores.
  std::vector<float> confidence;
  RobustResult robust;          ///< estimated from `pairs`; columns are empty where it was not
  std::vector<uint8_t> inlier;  ///< N flags: those of `robust`; where the filter alone decides, all; empty: none
  int inliers = 0;              ///< so many
  bool stationary = false;      ///< the camera stands still: what is static moved less than its noise
  Shutter shutter;              ///< of the camera, as the stream has shown it until this pair
  StageTimes times;
  /// MatchFilter::process alone fills these two. The id is constant while every image has the feature; 0: no inlier.
  std::vector<uint32_t> track_id;
  std::vector<uint16_t> track_length;  ///< images that have the id, at least 2; 0: no track
  LearnedMask mask;                    ///< what the stream has shown to be fixed to the camera before this pair
  std::vector<Match> masked;           ///< left out of `raw`: an end is in a covered cell or beside one

  int size() const { return static_cast<int>(matches.size()); }
  bool isInlier(size_t row) const { return !inlier.empty() && inlier[row] != 0; }
  /// 0..1, that the match is right; 0 without a model.
  float probability(size_t row) const {
    return robust.judgement.probability.empty() ? 0 : robust.judgement.probability[row];
  }
  /// Calls visit(match, stage, row) for every raw match, in order; of one with kRaw the row says nothing.
  template <typename Visit>
  void forEachRaw(const Visit& visit) const {
    size_t row = 0;
    for (const Match& match : raw) {
      const bool kept = row < matches.size() && matches[row].reference == match.reference;
      visit(match, !kept ? MatchStage::kRaw : isInlier(row) ? MatchStage::kInlier : MatchStage::kGms, row);
      if (kept) ++row;
    }
  }

  void clear(Status new_status);
  /// Treats the pair as one without a model.
  void reject();
};

}  // namespace gms_ransac
