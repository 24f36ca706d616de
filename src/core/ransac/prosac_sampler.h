// Progressive sample consensus (Chum & Matas, CVPR 2005).
#pragma once

#include <vector>

#include "ransac/sampler.h"

namespace gms_ransac {

/// Draws from ever longer prefixes of the order, and stops on the one that makes further draws pointless. The printed
/// Algorithm 1 has the two branches of the draw exchanged; here the n-th match is in the sample while the prefix grows.
class ProsacSampler : public Sampler {
 public:
  void begin(const SamplingTask& task);
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
