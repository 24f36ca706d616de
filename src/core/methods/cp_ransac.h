// The sampler of the paper's method; its use, and the rest of Section III, is in cp_ransac.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ransac/sampler.h"

namespace gms_ransac {

/// Confidence groups of the paper: draws come from group g until its bound is met with support beyond chance. The next
/// group is used if it needs fewer draws, or if a group has used its share of the budget. The last group holds all.
class ConfidenceGroupSampler : public Sampler {
 public:
  /// `first_fraction` in (0, 1]: share of the first group. `geometric`: each further group takes that share of the
  /// rest, down to kSmallestRest.
  ConfidenceGroupSampler(double first_fraction, bool geometric)
      : first_fraction_(first_fraction), geometric_(geometric) {}
  void begin(const SamplingTask& task);
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

  int phase() const { return static_cast<int>(phase_); }

 private:
  struct Group {
    int size;   ///< ranks, from the first
    int bound;  ///< draws from this group that make the success probability
  };
  bool phaseFailed() const;

  double first_fraction_;
  bool geometric_;
  SamplingTask task_;
  std::vector<Group> groups_;
  ChanceSupport chance_;
  size_t phase_ = 0;
  int drawn_ = 0, drawn_in_phase_ = 0;
  bool supported_ = false;  ///< the best hypothesis has more support than chance gives
};

}  // namespace gms_ransac
