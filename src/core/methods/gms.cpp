// `gms` (Bian et al. 2017) and `gms5` (Chen et al. 2018): the filter and nothing behind it. Its survivors are the
// inliers; a uniform search, whose model is always refined, gives only the pose.

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class Gms : public TextbookMethod {
 public:
  using TextbookMethod::TextbookMethod;
  bool filterDecides() const override { return true; }
};

/// Centre, north, east, south and west vote; the threshold factor shrinks with the square root of 5/9.
std::unique_ptr<Method> makeGmsFive(const MatchFilterOptions& options) {
  MatchFilterOptions five = options;
  five.motion_statistics.neighborhood = GridNeighborhood::kFive;
  return std::make_unique<Gms>(five);
}

}  // namespace

const MethodEntry kGms = {"gms", "Bian et al. 2017",
                          "GMS alone: its survivors are the inliers, uniform samples give only the pose", false,
                          &make<Gms>};
const MethodEntry kGmsFive = {"gms5", "Chen et al. 2018", "GMS alone with five cells that vote instead of nine", false,
                              &makeGmsFive};

}  // namespace gms_ransac
