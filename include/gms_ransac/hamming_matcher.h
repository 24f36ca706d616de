// Second stage, features -> matches: exact brute-force nearest neighbours under the Hamming distance.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gms_ransac/descriptor_set.h"
#include "gms_ransac/simd.h"

namespace gms_ransac {

/// Nearest neighbour of one reference descriptor among the current ones.
struct Match {
  int32_t reference;         ///< index into the reference features (the query)
  int32_t current;           ///< index into the current features; the lowest on ties, as in cv::BFMatcher
  uint16_t distance;         ///< Hamming, 0..256
  uint16_t second_distance;  ///< of the second-nearest current descriptor (another index); 257 when there is none
};

struct HammingMatcherOptions {
  bool mutual = false;  ///< keep only pairs that are each other's nearest neighbour, the lowest on ties (Lan 2020)
  int threads = 1;      ///< 1 to 64, of a pool that the whole process shares; the result does not depend on it
  SimdLevel simd = detectSimdLevel();

  /// Throws std::invalid_argument with a sentence that names the field, its value and its range.
  void validate() const;
};

class HammingMatcher {
 public:
  explicit HammingMatcher(const HammingMatcherOptions& options = {});
  ~HammingMatcher();
  HammingMatcher(HammingMatcher&&) noexcept;
  HammingMatcher& operator=(HammingMatcher&&) noexcept;

  /// One match per reference descriptor in reference order (fewer with `mutual`; none when either side is empty).
  /// `current` should be packed for the level of the options; if it is not, a copy is packed at every call.
  /// Identical on every SIMD level and for any number of threads. Reuses the storage of `matches`; no allocation once
  /// warm.
  void match(const DescriptorSet& reference, const DescriptorSet& current, std::vector<Match>& matches);

 private:
  struct Workspace;
  HammingMatcherOptions options_;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace gms_ransac
