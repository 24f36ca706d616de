// `gms_ransac` (Zhang et al. 2022): GMS, then RANSAC on its survivors; the baseline of the paper's 32 %. Only the
// abstract could be read: "with the threshold" is taken for an early stop at target_inlier_ratio, off by default.
#include "methods/ransac_method.h"
#include "methods/registry.h"

namespace gms_ransac {

namespace {

class GmsRansac : public GmsMethod {
 public:
  explicit GmsRansac(const MatchFilterOptions& options) : GmsMethod(options), sampler_(stopOf(options.robust)) {}

  std::optional<Hypothesis> findBest() override { return search(sampler_, verifier_); }

 private:
  static UniformSampler::Options stopOf(const RobustOptions& options) {
    UniformSampler::Options sampling;
    sampling.target_inlier_ratio = options.target_inlier_ratio;
    return sampling;
  }

  UniformSampler sampler_;
  CountingVerifier verifier_;
};

}  // namespace

const MethodEntry kGmsRansac = {"gms_ransac", "Zhang et al. 2022", "GMS, then uniform samples from its survivors",
                                false, &make<GmsRansac>};

}  // namespace gms_ransac
