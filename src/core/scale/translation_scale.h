// The length of the translation, which two images alone do not tell, carried on from pair to pair.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/triangulation.h"

namespace gms_ransac {

enum class ScaleMode { kUnit, kPropagate, kDepth, kFixed, kOdometry, kGround };

/// True if known lengths are in metres.
inline bool measuresMetres(ScaleMode mode) {
  return mode == ScaleMode::kDepth || mode == ScaleMode::kOdometry || mode == ScaleMode::kGround;
}

struct ScaleEstimate {
  double length = 1;          ///< of the translation; metres when it came from depth
  double relative_sigma = 0;  ///< standard deviation of `length` over `length`
  int features = 0;           ///< that it rests on; 0: not measured, `length` is the previous one
};

/// `propagate`: a feature in three images has one depth in the middle one, which gives the second translation in units
/// of the first. Inverse depths of features seen longer are averaged to slow the drift.
class ScalePropagator {
 public:
  /// Length of this pair's translation (`pose.t` of unit length). `after_loss`: it may be many times the last. That of
  /// the first pair is 1, without error. One that too few features tell is the previous one, with an error of its size.
  ScaleEstimate update(const Triangulation& pair, const MatchResult& result, const Camera& camera,
                       bool after_loss = false);
  /// Replaces `update` for a pure rotation: depths are carried over, the length stays.
  void carryThroughRotation(const Triangulation& pair, const MatchResult& result);
  void advance();
  void reset();

 private:
  struct InverseDepth {
    double value = 0, variance = 0;  ///< variance 0: unknown
  };
  ScaleEstimate measure(const Triangulation& pair, const MatchResult& result, double pixel, bool after_loss);
  /// Median ratio of the best observed; not positive where they lie beyond infinity.
  double startingLength() const;
  void carryOn(const Triangulation& pair, const MatchResult& result, double pixel, double length);

  struct Ratio {
    double unit, unit_variance;    ///< inverse depth by this pair, baseline 1
    double known, known_variance;  ///< inverse depth from before
  };
  std::vector<Ratio> ratios_;
  std::vector<InverseDepth> reference_, current_;
  double length_ = 1;
  bool has_unit_ = false;  ///< the first length of all is the unit of the others
};

/// The pose scaled to that length, with the covariance of t.
RelativePose withLength(const RelativePose& unit_pose, const ScaleEstimate& scale);

}  // namespace gms_ransac
