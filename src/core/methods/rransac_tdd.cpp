// `rransac_tdd` (Matas & Chum 2004): RANSAC with the T(d,d) test before every full verification.
#include "methods/ransac_method.h"
#include "methods/registry.h"

namespace gms_ransac {

namespace {

class RansacTdd : public UnfilteredMethod {
 public:
  explicit RansacTdd(const MatchFilterOptions& options)
      : UnfilteredMethod(options), sampler_(boundFor(options.robust)), verifier_(options.robust.tdd_d) {}

  std::optional<Hypothesis> findBest() override {
    // A hypothesis is verified on all matches only if tdd_d random ones fit.
    return search(sampler_, verifier_);
  }

 private:
  /// A good hypothesis passes the test with w^d, so the bound has n + d for n.
  static UniformSampler::Options boundFor(const RobustOptions& options) {
    UniformSampler::Options sampling;
    sampling.extra_tests = options.tdd_d;
    return sampling;
  }

  UniformSampler sampler_;
  CountingVerifier verifier_;
};

}  // namespace

const MethodEntry kRransacTdd = {"rransac_tdd", "Matas & Chum 2004",
                                 "as ransac, but d random matches must fit before all are looked at", false,
                                 &make<RansacTdd>};

}  // namespace gms_ransac
