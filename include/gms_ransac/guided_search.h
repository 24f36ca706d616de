// Second stage, faster: most reference descriptors are compared only with those current ones that are near where their
// surroundings moved (doc/guided_search.md).
#pragma once

#include <memory>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

struct MotionPrediction;

/// With which current descriptors each reference descriptor is compared.
enum class SearchMode {
  kFull,   ///< all
  kGuided  ///< those near where its surroundings moved; all where that is not known
};

class GuidedSearch {
 public:
  /// `statistics`: of the pair's first matches, which are always weighed as by Criterion::kEvidence. Of the matcher's
  /// options `mutual` must be off.
  GuidedSearch(const HammingMatcherOptions& matcher, const MotionStatisticsOptions& statistics);
  ~GuidedSearch();
  GuidedSearch(GuidedSearch&&) noexcept;
  GuidedSearch& operator=(GuidedSearch&&) noexcept;

  /// At most one match per reference descriptor, in reference order; none where the motion of the surroundings is known
  /// and nothing alike is found there. Of a match that was searched so, `second_distance` is that of the second nearest
  /// where it was searched, at most what the second nearest of a full search usually has. Images without common motion
  /// get exactly what HammingMatcher gives. `prior` is used only if more of the first matches lie where it says than do
  /// by chance, and there only for points whose surroundings do not show their motion; what is not found where it says
  /// is searched in full, what is out of view there not at all. Identical on every SIMD level and for any number of
  /// threads; no allocation once warm.
  void match(const Features& reference, const Features& current, std::vector<Match>& matches,
             const MotionPrediction* prior = nullptr);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace gms_ransac
