// The one loop of RANSAC (Fischler & Bolles 1981). All methods share it; they differ in the parts they hand to it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gms_ransac/robust_result.h"
#include "ransac/sampler.h"
#include "ransac/verifier.h"
#include "time_budget.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

/// Local optimisation of every new best hypothesis (Chum, Matas & Kittler 2003).
struct LocalOptimization {
  Loss loss;
  int iterations = 0;  ///< 0: none, as in the textbook
};

/// The search for the best-supported hypothesis over the columns of one pair. Keeps its storage from pair to pair.
class Ransac {
 public:
  /// Starts anew. `order`: columns, most confident first. All must outlive the search.
  void begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order,
             Verifier& verifier, const LocalOptimization& optimization, Random& random, Effort& effort);
  /// Verifies a hypothesis from elsewhere; true if it became the best.
  bool offer(const Hypothesis& hypothesis);
  void search(Sampler& sampler);

  void setTimeLimit(const TimeLimit* limit) { limit_ = limit; }
  /// True if the limit, if any, leaves little time for refinement.
  bool late() const { return limit_ != nullptr && limit_->late(); }

  const std::optional<Hypothesis>& best() const { return best_; }
  const std::vector<float>& residuals();

 private:
  bool drawOne(Sampler& sampler);
  void tellSampler(Sampler& sampler);

  const TwoViewModel* model_ = nullptr;
  PointColumnsView points_ = {};
  const std::vector<int>* order_ = nullptr;
  Verifier* verifier_ = nullptr;
  LocalOptimization optimization_;
  Random* random_ = nullptr;
  Effort* effort_ = nullptr;
  const TimeLimit* limit_ = nullptr;

  std::optional<Hypothesis> best_;
  std::vector<float> residuals_;
  std::vector<uint8_t> inlier_;  ///< by rank
};

}  // namespace gms_ransac
