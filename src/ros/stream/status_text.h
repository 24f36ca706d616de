// The outcome of an image in words, as a user reads it in ~stats, on the overlay and in the log.
#pragma once

#include <cstdint>
#include <string>

#include "stream/processed_frame.h"
#include "stream/stream.h"

namespace gms_ransac {

/// "OK", ..., "BAD_IMAGE": a value of MatchStats::status.
std::string statusName(uint8_t status);

/// The reasons of an answer, with the remedy where something can be done. `options`: those it was made with.
std::string words(const ProcessedFrame& answer, const ProcessorOptions& options);

}  // namespace gms_ransac
