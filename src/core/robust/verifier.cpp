#include "robust/verifier.h"

#include "robust/sampler.h"

namespace gms_ransac {

namespace {

bool passesRandomTests(const TwoViewProblem& problem, const OrderedPoints& points, const Eigen::Matrix3d& model,
                       int tests, Random& random, int64_t& evaluations) {
  for (int i = 0; i < tests; ++i) {
    const int place = random.below(points.size());
    ++evaluations;
    if (problem.countInliers(model, points, place, place + 1) == 0) return false;
  }
  return true;
}

}  // namespace

Support Verifier::verify(const TwoViewProblem& problem, const OrderedPoints& points, const Eigen::Matrix3d& model,
                         Random& random, int64_t& evaluations) const {
  if (choice_ == VerifierChoice::kTdd && !passesRandomTests(problem, points, model, tests_, random, evaluations)) {
    return {};
  }
  const int n = points.size();
  const int held_out = choice_ == VerifierChoice::kHoldOut ? prefixLength(split_, n, problem.sampleSize()) : 0;
  evaluations += n;
  return {problem.countInliers(model, points, held_out, n), problem.countInliers(model, points, 0, held_out)};
}

}  // namespace gms_ransac
