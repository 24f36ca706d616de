// How much support a hypothesis has among the matches, and at what cost that is found out.
#pragma once

#include <cstdint>

#include "robust/inlier_counter.h"
#include "robust/random.h"
#include "robust/two_view_problem.h"

namespace gms_ransac {

/// Inliers, and those that decide between equals.
struct Support {
  int inliers = 0;
  int tie_breaker = 0;

  bool operator<(const Support& other) const {
    return inliers < other.inliers || (inliers == other.inliers && tie_breaker < other.tie_breaker);
  }
};

/// One of: all matches (textbook); T(d,d), all matches after d random ones have fitted (Matas & Chum 2004); hold-out,
/// the matches that samples do not come from, ties by those they come from (Ci et al. 2022); all where none are left.
class Verifier {
 public:
  Verifier(VerifierChoice choice, const RobustOptions& options)
      : choice_(choice), tests_(options.tdd_d), split_(options.split), judges_(options.simd), sampled_(options.simd) {}

  /// The matches to verify on, which must outlive the verifier's use.
  void begin(const TwoViewProblem& problem, const OrderedPoints& points);
  /// `evaluations` is raised by the residuals computed.
  Support verify(const Eigen::Matrix3d& model, Random& random, int64_t& evaluations) const;

 private:
  bool passesRandomTests(const Eigen::Matrix3d& model, Random& random, int64_t& evaluations) const;

  VerifierChoice choice_;
  int tests_;
  double split_;
  const TwoViewProblem* problem_ = nullptr;
  const OrderedPoints* points_ = nullptr;
  InlierCounter judges_, sampled_;  ///< held-out and sampled matches; all are judges unless there is a hold-out
};

}  // namespace gms_ransac
