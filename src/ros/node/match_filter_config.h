// The parameters of cfg/MatchFilter.cfg as the class that dynamic_reconfigure makes of them. Costly to compile: whoever
// wants the values takes them from reconfigure.h.
#pragma once

#include <string>
#include <vector>

#include <gms_ransac/MatchFilterConfig.h>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

/// What dynamic_reconfigure is given for MatchFilterConfig. It brings a number out of its range to the nearest one
/// allowed without a word; here nothing is changed, and `problem` says what was asked for, so that it can be refused.
struct UnclampedConfig : MatchFilterConfig {
  UnclampedConfig() = default;
  UnclampedConfig(const MatchFilterConfig& config) : MatchFilterConfig(config) {}  // implicit: the server converts so
  /// Hides the one that dynamic_reconfigure generates; its server calls it with every request.
  void __clamp__();

  std::vector<std::string> renamed;  ///< a sentence for each old word, already replaced
  std::string problem;  ///< names every number out of range and every unknown word, and what is accepted; empty: none
};

/// The core's options from the reconfigurable parameters; throws std::invalid_argument when they contradict each other.
MatchFilterOptions coreOptions(const MatchFilterConfig& config);

}  // namespace gms_ransac
