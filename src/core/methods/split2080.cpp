// `split2080` (Ci et al. 2022): samples from the best fifth by descriptor distance, verified on the others. Their "form
// a new sample set" is read as cross-validation: support is counted on the matches that are not sampled, ties by those
// that are; inliers come from both.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class Split2080 : public UnfilteredMethod {
 public:
  explicit Split2080(const MatchFilterOptions& options)
      : UnfilteredMethod(options, {options.robust.split_fraction, 0, {}}), hold_out_(options.robust.split_fraction) {}

  std::optional<Hypothesis> findBest() override {
    sort(options_.sort_key.value_or(SortKey::kDistance));
    return search(sampler_, hold_out_);
  }

 private:
  HoldOutVerifier hold_out_;
};

}  // namespace

const MethodEntry kSplit2080 = {"split2080", "Ci et al. 2022",
                                "samples from the best fifth by descriptor distance, verified on the others", true,
                                &make<Split2080>};

}  // namespace gms_ransac
