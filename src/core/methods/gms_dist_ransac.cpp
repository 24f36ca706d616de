// `gms_dist_ransac` (Zhu et al. 2019): GMS, then matches with displacements as long as their neighbours', then
// RANSAC. The paper does not state the criterion; distance_reading chooses between two readings (see
// gms/distance_consistency.h).
#include "gms/distance_consistency.h"

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class GmsDistanceRansac : public TextbookMethod {
 public:
  explicit GmsDistanceRansac(const MatchFilterOptions& options)
      : TextbookMethod(options), reading_(options.distance_reading) {}

  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override {
    TextbookMethod::filter(reference, current, matches);
    rejectInconsistent(reading_, options_.seed, reference, current, matches, statistics_);
    return statistics_;
  }

 private:
  DistanceReading reading_;
};

}  // namespace

const MethodEntry kGmsDistanceRansac = {"gms_dist_ransac", "Zhu et al. 2019",
                                        "GMS, then matches that move as far as their neighbours, uniform samples",
                                        false, &make<GmsDistanceRansac>};

}  // namespace gms_ransac
