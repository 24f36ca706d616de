// Second stage, features -> matches: exact brute-force nearest neighbours under the Hamming distance.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/simd.h"

namespace gms_ransac {

struct Match {
  int32_t reference;  ///< index into the reference features (the query)
  int32_t current;    ///< index into the current features; the lowest on ties, as in cv::BFMatcher
  /// Hamming, 0..256. MatchFilter scales those of other descriptors to this range: the bits of K bytes by 32 / K; L2 so
  /// that perpendicular vectors of the images' root-mean-square length are 128 apart.
  uint16_t distance;
  uint16_t second_distance;  ///< of the second-nearest current descriptor (another index); 257 when there is none
};

struct HammingMatcherOptions {
  bool mutual = false;  ///< keep only pairs that are each other's nearest neighbour, the lowest on ties (Lan 2020)
  int threads = 1;      ///< 1 to 64, of a pool that the whole process shares; the result does not depend on it
  SimdLevel simd = detectSimdLevel();

  void validate() const;
};

class HammingMatcher {
 public:
  explicit HammingMatcher(const HammingMatcherOptions& options = {});
  ~HammingMatcher();
  HammingMatcher(HammingMatcher&&) noexcept;
  HammingMatcher& operator=(HammingMatcher&&) noexcept;

  /// One match per reference descriptor in its order; fewer with `mutual`. `current` should be packed for the level of
  /// the options, else a copy is packed at every call. The result depends neither on level nor threads. No allocation
  /// once warm. Throws std::invalid_argument for descriptors that are not of 32 bytes.
  void match(const DescriptorSet& reference, const DescriptorSet& current, std::vector<Match>& matches);

 private:
  struct Workspace;
  HammingMatcherOptions options_;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace gms_ransac
