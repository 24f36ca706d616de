// How a hypothesis is compared with the best so far, and at what cost that is found out.
#pragma once

#include <vector>

#include "gms_ransac/robust_result.h"
#include "random.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

class Verifier {
 public:
  virtual ~Verifier() = default;
  /// A new pair; nothing is best yet. `order`: columns, most confident first. All must outlive the verifier's use.
  virtual void begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order) = 0;
  /// True when the hypothesis has more support than every one before, which makes it the best.
  virtual bool beatsBest(const Hypothesis& hypothesis, Random& random, Effort& effort) = 0;
};

/// Inliers among all matches. With `tests` d above 0 the T(d,d) test of Matas & Chum 2004: d random matches must fit
/// before all are looked at.
class CountingVerifier : public Verifier {
 public:
  explicit CountingVerifier(int tests = 0) : tests_(tests) {}
  void begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order) override;
  bool beatsBest(const Hypothesis& hypothesis, Random& random, Effort& effort) override;

 private:
  bool passesRandomTests(const Hypothesis& hypothesis, Random& random, Effort& effort) const;

  int tests_;
  const TwoViewModel* model_ = nullptr;
  PointColumnsView points_ = {};
  const std::vector<int>* order_ = nullptr;
  int best_inliers_ = 0;
};

/// Inliers among the matches that samples do not come from, ties by the others (Ci et al. 2022); all where none are
/// left.
class HoldOutVerifier : public Verifier {
 public:
  explicit HoldOutVerifier(double fraction) : fraction_(fraction) {}
  void begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order) override;
  bool beatsBest(const Hypothesis& hypothesis, Random& random, Effort& effort) override;

 private:
  double fraction_;
  const TwoViewModel* model_ = nullptr;
  PointColumns held_out_, sampled_;
  int best_inliers_ = 0, best_sampled_inliers_ = 0;
};

/// Truncated cost over all matches (MSAC, Torr & Zisserman 2000), given up as soon as it exceeds the best.
class CostVerifier : public Verifier {
 public:
  void begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order) override;
  bool beatsBest(const Hypothesis& hypothesis, Random& random, Effort& effort) override;

 private:
  const TwoViewModel* model_ = nullptr;
  PointColumnsView points_ = {};
  float best_cost_ = 0;
};

}  // namespace gms_ransac
