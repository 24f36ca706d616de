// `ransac` (Fischler & Bolles 1981): the textbook, on all nearest neighbours.
#include "methods/ransac_method.h"
#include "methods/registry.h"

namespace gms_ransac {

namespace {

class PlainRansac : public UnfilteredMethod {
 public:
  explicit PlainRansac(const MatchFilterOptions& options) : UnfilteredMethod(options) {}

  std::optional<Hypothesis> findBest() override {
    // Uniform samples until the bound k = log(1 - p) / log(1 - w^n) from the best inlier ratio w; every hypothesis is
    // verified on all matches.
    return search(sampler_, verifier_);
  }

 private:
  UniformSampler sampler_;
  CountingVerifier verifier_;
};

}  // namespace

const MethodEntry kRansac = {"ransac", "Fischler & Bolles 1981", "uniform samples from all nearest neighbours", false,
                             &make<PlainRansac>};

}  // namespace gms_ransac
