// `gms_ransac` (Zhang et al. 2022): GMS, then RANSAC on its survivors; the baseline of the paper's 32 %. Only the
// abstract could be read: "with the threshold" is taken for an early stop at target_inlier_ratio, off by default.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class GmsRansac : public GmsMethod {
 public:
  explicit GmsRansac(const MatchFilterOptions& options)
      : GmsMethod(options, {1, 0, options.robust.target_inlier_ratio}) {}
};

}  // namespace

const MethodEntry kGmsRansac = {"gms_ransac", "Zhang et al. 2022", "GMS, then uniform samples from its survivors",
                                false, &make<GmsRansac>};

}  // namespace gms_ransac
