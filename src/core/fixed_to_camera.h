// Separates what is fixed to the camera (on-screen text, a bonnet, the arm of a robot) from the view behind it.
// doc/inside/judgement.md says why.
#pragma once

#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"
#include "methods/method.h"
#include "subset_estimate.h"

namespace gms_ransac {

/// Keeps its storage from pair to pair.
class FixedToCamera {
 public:
  /// `method` has just estimated `result`. If many matches stayed where they were in the image, and the others have a
  /// motion that excludes these, cells vote which of both is static. If the others win, their motion becomes the
  /// result. If what stayed wins, the camera is at rest and a body passes: the result stands. If nobody wins, or the
  /// others are all over the view, the direction is unknown, and the rotation as uncertain as the two differ. `past`:
  /// of the stream; null: none.
  void resolve(Method& method, const Camera& camera, MatchResult& result, const Past* past);

 private:
  /// Sorts the matches into those that stayed and the others; true if both are many and the others moved far.
  bool separate(const PointPairs& pairs);
  /// True if the motion of the others explains most of them, and moves most of those that stayed.
  bool contradicts(const Camera& camera, const PointPairs& pairs);
  /// That what stayed is the static scene, before a camera at rest, and what moves a body.
  double probabilityOfRest(const MatchResult& result, const Past* past) const;

  std::vector<int> fixed_;  ///< matches that stayed
  SubsetEstimate others_;
  std::vector<float> squares_;
};

}  // namespace gms_ransac
