// Compares an answer with the past of its stream: a direction that breaks with the motion so far must be shown by the
// matches that continue static tracks. doc/inside/judgement.md says why.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"
#include "gms_ransac/robust_options.h"
#include "methods/method.h"

namespace gms_ransac {

class Continuity {
 public:
  /// `method` has just estimated `result`. If the direction is new and the static tracks alone show another motion,
  /// that motion becomes the result; where they are too few to show any, a steady stream refuses the pair. If the
  /// direction is not known and the static tracks alone continue the stream, their motion becomes the result. Then
  /// updates `past`. A direction that the pair before did not show at all must be known twice as well as others.
  /// Without RobustOptions::judge the answer stands.
  void follow(Method& method, const Camera& camera, const RobustOptions& options, MatchResult& result, Past& past);

 private:
  /// Selects the matches that continue static tracks.
  void select(const Past& past, const MatchResult& result);
  /// Makes the estimate from the static tracks that of all matches.
  void take(const Camera& camera, MatchResult& result);

  std::vector<int> tracks_;  ///< matches that continue static tracks
  PointPairs pairs_;         ///< and their columns
  RobustResult alone_;       ///< what they show
  std::vector<uint8_t> inlier_;
  std::vector<float> probability_, residual_;
};

}  // namespace gms_ransac
