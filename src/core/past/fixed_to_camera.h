// Separates what is fixed to the camera (on-screen text, a bonnet, the arm of a robot) from the view behind it.
// doc/inside/judgement.md says why.
#pragma once

#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"
#include "methods/method.h"
#include "past/subset_estimate.h"

namespace gms_ransac {

/// Keeps its storage from pair to pair.
class FixedToCamera {
 public:
  /// `method` has just estimated `result`. Many matches may have stayed in place while the others have a motion that
  /// excludes these: a body passes a camera at rest, or a view moves behind something that is fixed to the camera.
  /// Their cells vote for one of the two. The motion of a view that surely moves replaces the result. Otherwise the
  /// covariance of the rotation holds both, and the direction is unknown unless one is improbable. `past`: of the
  /// stream; null: none.
  void resolve(Method& method, const Camera& camera, MatchResult& result, const Past* past);
  /// The motion of what moves as one, after `resolve` has left it open or has decided for a camera at rest; otherwise
  /// that of the result.
  const Judgement& view(const MatchResult& result) const {
    return (others_move_ ? others_.robust : result.robust).judgement;
  }

 private:
  /// Sorts the matches into those that stayed and the others; true if both are as many as `least` and the others moved
  /// far. `few`: a few others are enough.
  bool separate(const PointPairs& pairs, double least, bool few);
  /// True if the motion of the others explains many of them.
  bool explained() const;
  /// True if it also moves most of those that stayed.
  bool contradicts(const Camera& camera, const PointPairs& pairs);
  /// Probability that the camera is at rest, before a body that moves.
  double probabilityOfRest(const MatchResult& result, const Past* past) const;

  bool others_move_ = false;
  std::vector<int> fixed_;  ///< rows of the matches that stayed
  SubsetEstimate others_;
  std::vector<float> squares_;
};

}  // namespace gms_ransac
