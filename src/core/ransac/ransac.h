// The one loop of RANSAC (Fischler & Bolles 1981). All methods share it; they differ in the parts they hand to it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gms_ransac/robust_estimator.h"
#include "gms_ransac/time_limit.h"
#include "ransac/sampler.h"
#include "ransac/verifier.h"
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
  /// Starts anew. `order`: the columns, most confident first, as the sampler counts them. What is referred to must
  /// outlive the search; `effort` counts what it costs.
  void begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order,
             Verifier& verifier, const LocalOptimization& optimization, Random& random, Effort& effort);
  /// Verifies a hypothesis from elsewhere: the previous motion, a start, another motion of a plane. True if it became
  /// the best.
  bool offer(const Hypothesis& hypothesis);
  /// Draws samples until the sampler has enough, or it is time.
  void search(Sampler& sampler);

  /// Of searches from now on; null: none.
  void setTimeLimit(const TimeLimit* limit) { limit_ = limit; }
  /// Whether the limit, if there is one, leaves little time for what follows.
  bool late() const { return limit_ != nullptr && limit_->late(); }

  /// Nothing while none was found.
  const std::optional<Hypothesis>& best() const { return best_; }
  /// Of the best hypothesis, by column.
  const std::vector<float>& residuals();

 private:
  /// Draws and verifies one sample; false when the sampler has enough.
  bool drawOne(Sampler& sampler);
  /// Tells the sampler which ranks the best hypothesis explains.
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
