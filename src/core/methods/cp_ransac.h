// The sampler of the paper's method; its use, and the rest of Section III, is in cp_ransac.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ransac/sampler.h"

namespace gms_ransac {

/// Confidence groups of the paper: group g holds the matches up to a cumulative share of N. Draws come from group g
/// alone until its own bound is met with a support over all matches that is no chance; a group that asks for more draws
/// than the next one, or than its share of the budget, gives way to the next. The last group holds all.
class ConfidenceGroupSampler : public Sampler {
 public:
  /// `first_fraction` in (0, 1]: share of the first group. Geometric: every further group adds that share of what is
  /// left, down to kSmallestRest matches; otherwise the second group is all.
  ConfidenceGroupSampler(double first_fraction, bool geometric)
      : first_fraction_(first_fraction), geometric_(geometric) {}
  void begin(const SamplingTask& task) override;
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

  int phase() const { return static_cast<int>(phase_); }

 private:
  struct Group {
    int size;   ///< matches, from the first in the order
    int bound;  ///< draws from this group that make the success probability
  };
  /// The current group asks for more draws than it may have, or than the next one would.
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
