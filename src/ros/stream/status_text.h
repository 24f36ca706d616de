// The outcome of an image in words, as a user reads it in ~stats, on the overlay and in the log.
#pragma once

#include <cstdint>
#include <string>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

struct PreparedFrame;
enum class Reset : uint8_t;

/// "OK", ..., "BAD_IMAGE": a value of MatchStats::status.
std::string statusName(uint8_t status);

/// As the beginning of a sentence; empty: no reset.
std::string explain(Reset reset);

/// Explains the outcome of a comparison, with the remedy. `status` may differ from that of `result`.
std::string explain(Status status, const MatchResult& result, const PreparedFrame& current);

}  // namespace gms_ransac
