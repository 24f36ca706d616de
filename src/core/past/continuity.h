// The room past holds an answer against what the pairs before it showed, or against what else is seen. Between two
// pairs nothing is kept but Past.
//
// Compares an answer with the past of its stream, and continues that: where its direction is new, the matches that
// continue static tracks may replace it. doc/inside/judgement.md says why.
#pragma once

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"
#include "methods/method.h"
#include "past/subset_estimate.h"

namespace gms_ransac {

class Continuity {
 public:
  /// `method` has just estimated `result`. If its direction is new or not known, and the static tracks alone continue
  /// the stream, their motion becomes the result. A direction that the pair before did not show at all must be known
  /// twice as well as others.
  void check(Method& method, const Camera& camera, MatchResult& result, const Past& past);

 private:
  /// Selects the matches that continue static tracks.
  void select(const Past& past, const MatchResult& result);

  SubsetEstimate tracks_;  ///< of the matches that continue static tracks
};

/// Moves `past` on by an answer, which gets the shutter that the stream has shown until then.
void continuePast(MatchResult& result, Past& past);

}  // namespace gms_ransac
