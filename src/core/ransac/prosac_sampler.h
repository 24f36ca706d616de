// Progressive sample consensus (Chum & Matas, CVPR 2005).
#pragma once

#include <vector>

#include "ransac/sampler.h"

namespace gms_ransac {

/// Draws as RANSAC would from ever longer prefixes of the order, the best matches first, and stops on the prefix that
/// makes further draws pointless.
///
/// The printed Algorithm 1 of the paper has the two branches of the draw exchanged. Here: while the prefix of n grows,
/// the n-th match is in the sample and the others come from the n - 1 before it; once it has stopped growing, all come
/// from the prefix.
class ProsacSampler : public Sampler {
 public:
  void begin(const SamplingTask& task) override;
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

  int prefix() const { return prefix_; }  ///< n, the matches that are drawn from
  bool growing() const { return drawn_ <= growth_; }

 private:
  void grow();

  SamplingTask task_;
  ChanceSupport chance_;
  int prefix_ = 0;             ///< n
  double expected_draws_ = 0;  ///< T_n: of T_N uniform draws, those within the first n
  int growth_ = 0;             ///< T'_n: the draw after which n grows
  int stop_prefix_ = 0;        ///< n*: growth ends here
  int drawn_ = 0, bound_ = 0;
};

}  // namespace gms_ransac
