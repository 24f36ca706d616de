#include "robust/verifier.h"

#include "robust/sampler.h"

namespace gms_ransac {

void Verifier::begin(const TwoViewProblem& problem, const OrderedPoints& points) {
  problem_ = &problem;
  points_ = &points;
  const int n = points.size();
  int sampled = choice_ == VerifierChoice::kHoldOut ? prefixLength(split_, n, problem.sampleSize()) : 0;
  if (sampled == n) sampled = 0;  // nothing is held out
  sampled_.set(problem, points, 0, sampled);
  judges_.set(problem, points, sampled, n);
}

Support Verifier::verify(const Eigen::Matrix3d& model, Random& random, int64_t& evaluations) const {
  if (choice_ == VerifierChoice::kTdd && !passesRandomTests(model, random, evaluations)) return {};
  evaluations += judges_.size() + sampled_.size();
  return {judges_.score(model).inliers, sampled_.score(model).inliers};
}

bool Verifier::passesRandomTests(const Eigen::Matrix3d& model, Random& random, int64_t& evaluations) const {
  for (int i = 0; i < tests_; ++i) {
    ++evaluations;
    if (!problem_->fits(model, *points_, random.below(points_->size()))) return false;
  }
  return true;
}

}  // namespace gms_ransac
