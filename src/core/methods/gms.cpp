// `gms` (Bian et al. 2017) and `gms5` (Chen et al. 2018): the filter and nothing behind it. Its survivors are the
// inliers; a uniform search, whose model is always refined, gives only the pose.
#include "methods/ransac_method.h"
#include "methods/registry.h"

namespace gms_ransac {

namespace {

class Gms : public GmsMethod {
 public:
  explicit Gms(const MatchFilterOptions& options, GridNeighborhood neighborhood = GridNeighborhood::kNine)
      : GmsMethod(options, neighborhood) {}

  std::optional<Hypothesis> findBest() override { return search(sampler_, verifier_); }
  bool filterDecides() const override { return true; }

 private:
  UniformSampler sampler_;
  CountingVerifier verifier_;
};

/// Centre, north, east, south and west vote; the threshold factor shrinks with the square root of 5/9.
class GmsFive : public Gms {
 public:
  explicit GmsFive(const MatchFilterOptions& options) : Gms(options, GridNeighborhood::kFive) {}
};

}  // namespace

const MethodEntry kGms = {"gms", "Bian et al. 2017",
                          "GMS alone: its survivors are the inliers, uniform samples give only the pose", false,
                          &make<Gms>};
const MethodEntry kGmsFive = {"gms5", "Chen et al. 2018", "GMS alone with five cells that vote instead of nine", false,
                              &make<GmsFive>};

}  // namespace gms_ransac
