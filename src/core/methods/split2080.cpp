// `split2080` (Ci et al. 2022): samples from the best fifth by descriptor distance, verified on the others. Their "form
// a new sample set" is read as cross-validation: support is counted on the matches that are not sampled, ties by those
// that are; inliers come from both.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class Split2080 : public UnfilteredMethod {
 public:
  explicit Split2080(const MatchFilterOptions& options)
      : UnfilteredMethod(options, {options.robust.split_fraction, 0, {}}) {}

  std::optional<Hypothesis> findBest(const PairTask& pair) override {
    sort(pair.pairs, options_.sort_key.value_or(SortKey::kDistance));
    HoldOutVerifier hold_out(*model_, points_.view(), order_, options_.split_fraction);
    return search(pair, sampler_, hold_out);
  }
};

}  // namespace

const MethodEntry kSplit2080 = {"split2080", "Ci et al. 2022",
                                "samples from the best fifth by descriptor distance, verified on the others", true,
                                &make<Split2080>};

}  // namespace gms_ransac
