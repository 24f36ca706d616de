// The stage of every raw match, for tests that compare results.
#pragma once

#include <vector>

#include "gms_ransac/match_result.h"

namespace gms_ransac {

inline std::vector<MatchStage> stagesOf(const MatchResult& result) {
  std::vector<MatchStage> stages;
  result.forEachRaw([&](const Match&, MatchStage stage, size_t) { stages.push_back(stage); });
  return stages;
}

}  // namespace gms_ransac
