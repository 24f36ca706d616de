// Answer for one image: the comparison, its status and its pose.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <gms_ransac/MatchStats.h>

#include "gms_ransac/match_filter.h"
#include "stream/prepared_frame.h"

namespace gms_ransac {

/// How an image follows on what came before it.
enum class Continuity {
  kContinuous,
  kBroken,    ///< the motion since the image before is not known: a gap, another image size
  kRestarted  ///< nothing before counts any more: the clock or the stamps went back, or a reset was asked for
};

/// The pointers live until the next image is processed.
struct ProcessedFrame {
  uint8_t status = MatchStats::FIRST_FRAME;
  std::string text;  ///< the status in words, with what to do where something can be done
  const PreparedFrame* current = nullptr;
  const PreparedFrame* reference = nullptr;  ///< null: not compared
  const MatchResult* result = nullptr;       ///< null: not compared
  Continuity continuity = Continuity::kContinuous;
  RelativePose pose;          ///< as it is published; if poseValid()
  bool metric_scale = false;  ///< pose.t is in metres
  /// One per entry of result->matches; 0: not followed.
  const std::vector<uint32_t>* track_ids = nullptr;
  const std::vector<uint16_t>* track_lengths = nullptr;
  bool reference_held = false;  ///< the next image will be compared with this reference again
  /// After a loss the reference is an image from before it. `status` is what it would be without the loss.
  bool recovered = false;
  /// Only with `recovered`: the length of the motion is unknown, `pose.t` is the direction alone.
  bool length_missing = false;
  double oldest_reference = kNoReference;  ///< no image of an earlier stamp will be a reference again, seconds
  static constexpr double kNoReference = std::numeric_limits<double>::infinity();

  bool poseValid() const {
    return result != nullptr && (status == MatchStats::OK || status == MatchStats::LOW_PARALLAX);
  }
  /// As ~stats has it.
  uint8_t publishedStatus() const { return recovered ? static_cast<uint8_t>(MatchStats::RECOVERED) : status; }
};

}  // namespace gms_ransac
