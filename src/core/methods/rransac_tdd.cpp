// `rransac_tdd` (Matas & Chum 2004): RANSAC with the T(d,d) test before every full verification.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

/// A hypothesis is verified on all matches only if d random ones fit. A good one passes with w^d, so the bound has
/// n + d for n.
std::unique_ptr<Method> makeRansacTdd(const MatchFilterOptions& options) {
  return std::make_unique<UnfilteredMethod>(options, UniformSampler::Options{1, options.robust.tdd_d, {}});
}

}  // namespace

const MethodEntry kRransacTdd = {"rransac_tdd", "Matas & Chum 2004",
                                 "as ransac, but d random matches must fit before all are looked at", false,
                                 &makeRansacTdd};

}  // namespace gms_ransac
