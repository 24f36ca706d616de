// `gms_dist_ransac` (Zhu et al. 2019): GMS, then matches with displacements as long as their neighbours', then
// RANSAC. The paper does not state the criterion; distance_reading chooses between two readings (see
// DistanceConsistency).
#include "gms/distance_consistency.h"

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class GmsDistanceRansac : public GmsMethod {
 public:
  explicit GmsDistanceRansac(const MatchFilterOptions& options)
      : GmsMethod(options), distance_consistency_(options.distance_reading, options.robust.seed) {}

  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override {
    gms_.compute(reference, current, matches, statistics_);
    distance_consistency_.apply(reference, current, matches, statistics_);
    return statistics_;
  }

 private:
  DistanceConsistency distance_consistency_;
};

}  // namespace

const MethodEntry kGmsDistanceRansac = {"gms_dist_ransac", "Zhu et al. 2019",
                                        "GMS, then matches that move as far as their neighbours, uniform samples",
                                        false, &make<GmsDistanceRansac>};

}  // namespace gms_ransac
