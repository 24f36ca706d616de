// How a hypothesis is compared with the best so far, and at what cost that is found out.
#pragma once

#include <vector>

#include "support/random.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

/// Lives as long as a search: nothing is best at first. `order`: slots by rank.
class Verifier {
 public:
  virtual ~Verifier() = default;
  /// True when the hypothesis has more support than every one before, which makes it the best.
  virtual bool beatsBest(const Hypothesis& hypothesis, Random& random) = 0;
};

/// Inliers among all matches. With `tests` d above 0 the T(d,d) test of Matas & Chum 2004: d random matches must fit
/// before all are looked at.
class CountingVerifier : public Verifier {
 public:
  CountingVerifier(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order,
                   int tests = 0)
      : model_(model), points_(points), order_(order), tests_(tests) {}
  bool beatsBest(const Hypothesis& hypothesis, Random& random) override;

 private:
  bool passesRandomTests(const Hypothesis& hypothesis, Random& random) const;

  const TwoViewModel& model_;
  PointColumnsView points_;
  const std::vector<int>& order_;
  int tests_, best_inliers_ = 0;
};

/// Inliers among the matches that samples do not come from, ties by the others (Ci et al. 2022); all where none are
/// left.
class HoldOutVerifier : public Verifier {
 public:
  HoldOutVerifier(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order,
                  double fraction);
  bool beatsBest(const Hypothesis& hypothesis, Random& random) override;

 private:
  const TwoViewModel& model_;
  PointColumns held_out_, sampled_;
  int best_inliers_ = 0, best_sampled_inliers_ = 0;
};

/// Truncated cost over all matches (MSAC, Torr & Zisserman 2000), given up as soon as it exceeds the best.
class CostVerifier : public Verifier {
 public:
  CostVerifier(const TwoViewModel& model, const PointColumnsView& points)
      : model_(model), points_(points), best_cost_(static_cast<float>(points.count)) {}
  bool beatsBest(const Hypothesis& hypothesis, Random& random) override;

 private:
  const TwoViewModel& model_;
  PointColumnsView points_;
  float best_cost_;
};

}  // namespace gms_ransac
