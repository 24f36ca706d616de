// The room methods has one file for each method, put together from the rooms below. A new one is a file with a
// MethodEntry, listed in method.cpp; methods do not include each other.
//
// The methods: each composes matching, filtering and robust estimation in one file of src/core/methods.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/match_filter_options.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/motion_statistics.h"
#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"
#include "support/time_budget.h"

namespace gms_ransac {

/// One method at work: what it does with the matches of a pair, stage by stage. Keeps nothing but storage from pair to
/// pair. Not thread-safe.
class Method {
 public:
  virtual ~Method() = default;

  virtual bool wantsMutualMatches() const { return false; }
  /// Verdict and score of every raw match; only accepted ones are estimated from. Valid until the next call.
  virtual const MotionStatistics& filter(const Features& reference, const Features& current,
                                         const std::vector<Match>& matches) = 0;
  /// Model, inliers and pose from the survivors. Without calibration essential becomes fundamental and there is no
  /// pose. model_found is false if there is none; never throws on data.
  virtual void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) = 0;
  /// A second filter, on the inliers of `result.robust`, where the method has one.
  virtual void postFilter(const Features& /*reference*/, const Features& /*current*/, MatchResult& /*result*/) {}
  /// True when all survivors of the filter are inliers and the model gives only the pose.
  virtual bool filterDecides() const { return false; }
  /// Replaces RobustOptions::seed from the next call on.
  virtual void setSeed(uint64_t seed) = 0;
  /// Outlives the method; asked while it estimates. Null, as at first: no limit, and no clock is read.
  virtual void setTimeLimit(const TimeLimit* limit) = 0;
};

struct MethodEntry {
  const char* name;
  const char* source;   ///< paper
  const char* summary;  ///< our reading of it, one line
  bool ordered;         ///< samples the most confident matches first
  std::unique_ptr<Method> (*make)(const MatchFilterOptions& options);
};

/// In the order in which they are listed to users.
const std::vector<MethodEntry>& methods();

/// The same as text: name, source and summary of each.
std::string methodsText();

/// Throws std::invalid_argument listing the known names.
const MethodEntry& findMethod(const std::string& name);

std::unique_ptr<Method> makeMethod(const MatchFilterOptions& options);

extern const MethodEntry kRansac, kRransacTdd, kProsac, kSubsetRansac, kSplit2080, kGms, kGmsFive, kGmsDistanceRansac,
    kLan, kGmsRansac, kCpRansac, kLoProsac;

template <class SomeMethod>
std::unique_ptr<Method> make(const MatchFilterOptions& options) {
  return std::make_unique<SomeMethod>(options);
}

}  // namespace gms_ransac
