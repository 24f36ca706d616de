// The parameters of cfg/MatchFilter.cfg as the class that dynamic_reconfigure makes of them. Slow to compile: include
// reconfigure.h for the values.
#pragma once

#include <string>

#include <gms_ransac/MatchFilterConfig.h>

#include "gms_ransac/match_filter.h"
#include "parameter.h"

namespace gms_ransac {

/// Replaces MatchFilterConfig in the server. dynamic_reconfigure clamps numbers silently; here they stay, and `problem`
/// names them, so that the request can be refused.
struct UnclampedConfig : MatchFilterConfig {
  UnclampedConfig() = default;
  UnclampedConfig(const MatchFilterConfig& config) : MatchFilterConfig(config) {}  // implicit: the server converts so
  /// Hides the one that dynamic_reconfigure generates; its server calls it with every request.
  void __clamp__();

  std::string problem;  ///< names every number out of range and every unknown word, and what is accepted; empty: none
};

/// The core's options from the parameters set at start and those that can change, which `config` holds. Throws
/// std::invalid_argument when they contradict each other.
MatchFilterOptions coreOptions(const ParameterValues& at_start, const MatchFilterConfig& config);

}  // namespace gms_ransac
