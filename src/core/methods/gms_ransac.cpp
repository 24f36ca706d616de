// `gms_ransac` (Zhang et al. 2022): GMS, then RANSAC on its survivors; the baseline of the paper's 32 %. Only the
// abstract could be read: "with the threshold" is taken for an early stop at target_inlier_ratio, off by default.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

std::unique_ptr<Method> makeGmsRansac(const MatchFilterOptions& options) {
  return std::make_unique<TextbookMethod>(options, UniformSampler::Options{1, 0, options.robust.target_inlier_ratio});
}

}  // namespace

const MethodEntry kGmsRansac = {"gms_ransac", "Zhang et al. 2022", "GMS, then uniform samples from its survivors",
                                false, &makeGmsRansac};

}  // namespace gms_ransac
