// `rransac_tdd` (Matas & Chum 2004): RANSAC with the T(d,d) test before every full verification.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class RansacTdd : public UnfilteredMethod {
 public:
  /// A hypothesis is verified on all matches only if d random ones fit. A good one passes with w^d, so the bound has
  /// n + d for n.
  explicit RansacTdd(const MatchFilterOptions& options)
      : UnfilteredMethod(options, {1, options.robust.tdd_d, {}}, options.robust.tdd_d) {}
};

}  // namespace

const MethodEntry kRransacTdd = {"rransac_tdd", "Matas & Chum 2004",
                                 "as ransac, but d random matches must fit before all are looked at", false,
                                 &make<RansacTdd>};

}  // namespace gms_ransac
