// `prosac` (Chum & Matas 2005): samples from growing prefixes of the matches, the best by descriptor first.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class Prosac : public UnfilteredMethod {
 public:
  using UnfilteredMethod::UnfilteredMethod;

  std::optional<Hypothesis> findBest(const PairTask& pair) override {
    sort(pair.pairs, options_.sort_key.value_or(SortKey::kDistance));
    // Growth function with T_N = 200000, non-randomness and maximality as in the paper (see ProsacSampler).
    return search(pair, prosac_);
  }

 private:
  ProsacSampler prosac_;
};

}  // namespace

const MethodEntry kProsac = {"prosac", "Chum & Matas 2005",
                             "samples from growing prefixes of the matches of least descriptor distance", true,
                             &make<Prosac>};

}  // namespace gms_ransac
