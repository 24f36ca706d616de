// The room ransac finds the best hypothesis, in an order of the matches, from samples and proposals. It knows a model
// by its interface alone.
//
// The one loop of RANSAC (Fischler & Bolles 1981). All methods share it; they differ in the parts they hand to it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gms_ransac/robust_result.h"
#include "ransac/sampler.h"
#include "ransac/verifier.h"
#include "support/time_budget.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

/// Local optimisation of every new best hypothesis (Chum, Matas & Kittler 2003).
struct LocalOptimization {
  Loss loss;
  int iterations = 0;  ///< 0: none, as in the textbook
};

/// Lent to a search, so that the next one finds it warm.
struct SearchStorage {
  std::vector<float> residuals;
  std::vector<uint8_t> inlier;  ///< by rank
};

/// Inputs of a search; all of them outlive it.
struct SearchParts {
  const TwoViewModel& model;
  const std::vector<int>& order;  ///< slots by rank, most confident first
  Random& random;
  Effort& effort;
  const TimeLimit* limit;  ///< null: none
  SearchStorage& storage;
};

/// The search for the best-supported hypothesis over the points of one pair.
class Ransac {
 public:
  Ransac(const SearchParts& parts, Verifier& verifier, const LocalOptimization& optimization = {})
      : parts_(parts), verifier_(verifier), optimization_(optimization) {}
  /// Verifies a hypothesis from elsewhere; true if it became the best.
  bool offer(const Hypothesis& hypothesis);
  void search(Sampler& sampler);

  const std::optional<Hypothesis>& best() const { return best_; }

 private:
  bool drawOne(Sampler& sampler);
  void tellSampler(Sampler& sampler);

  SearchParts parts_;
  Verifier& verifier_;
  LocalOptimization optimization_;
  std::optional<Hypothesis> best_;
};

}  // namespace gms_ransac
