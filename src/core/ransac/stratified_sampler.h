// Draws minimal samples from the most confident matches first (PROSAC, Chum & Matas 2005), spread over the image.
#pragma once

#include <cstdint>
#include <vector>

#include "ransac/sampler.h"

namespace gms_ransac {

/// The first matches of an order lie close together and neighbours fix a model badly. Members of a sample come from
/// distinct cells of the spread grid, two of them a fifth of it apart. Ends at the bound from the inlier ratio of the
/// present prefix.
class StratifiedSampler : public Sampler {
 public:
  /// `order`: columns, most confident first; `cells`: of each column; `first_share`: of the matches, which the first
  /// samples come from.
  void begin(const SamplingTask& task, const std::vector<int>& order, const std::vector<int32_t>& cells,
             double first_share = kFirstShare);
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

  int prefix() const { return drawn_from_; }

 private:
  static constexpr double kFirstShare = 0.02;  ///< doc/estimator.md

  bool spread(const int* sample) const;
  void updateBound();

  std::vector<int32_t> cells_;  ///< by rank
  SamplingTask task_;
  double prefix_ = 0, growth_ = 1;
  int drawn_from_ = 0, bound_prefix_ = 0;
  int drawn_ = 0, required_ = 0;
  std::vector<uint8_t> inlier_;  ///< of the best hypothesis, by rank; empty: none yet
};

}  // namespace gms_ransac
