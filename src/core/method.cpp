#include "gms_ransac/method.h"

#include <stdexcept>

namespace gms_ransac {

const std::vector<Method>& methods() {
  using M = MatcherChoice;
  using F = FilterChoice;
  using O = OrderingChoice;
  using S = SamplerChoice;
  using V = VerifierChoice;
  using R = RecheckChoice;
  static const std::vector<Method> table = {
      {"ransac", "Fischler & Bolles 1981", "uniform samples from all nearest neighbours", M::kNearest, F::kNone,
       O::kNone, S::kUniform, V::kAll, R::kNone, false},
      {"rransac_tdd", "Matas & Chum 2004", "as ransac, but d random matches must fit before all are looked at",
       M::kNearest, F::kNone, O::kNone, S::kUniform, V::kTdd, R::kNone, false},
      {"prosac", "Chum & Matas 2005", "samples from growing prefixes of the matches of least descriptor distance",
       M::kNearest, F::kNone, O::kDescriptorDistance, S::kProsac, V::kAll, R::kNone, false},
      {"subset_ransac", "Xu 2012", "ransac inside random subsets, the winner by its score on all matches", M::kNearest,
       F::kNone, O::kNone, S::kRandomSubsets, V::kAll, R::kNone, false},
      {"split2080", "Ci et al. 2022", "samples from the best fifth by descriptor distance, verified on the others",
       M::kNearest, F::kNone, O::kDescriptorDistance, S::kSplit, V::kHoldOut, R::kNone, false},
      {"gms", "Bian et al. 2017", "GMS alone: its survivors are the inliers, uniform samples give only the pose",
       M::kNearest, F::kGms, O::kNone, S::kUniform, V::kAll, R::kNone, true},
      {"gms5", "Chen et al. 2018", "GMS alone with five cells that vote instead of nine", M::kNearest, F::kGmsFive,
       O::kNone, S::kUniform, V::kAll, R::kNone, true},
      {"gms_dist_ransac", "Zhu et al. 2019", "GMS, then matches that move as far as their neighbours, uniform samples",
       M::kNearest, F::kGmsDistance, O::kNone, S::kUniform, V::kAll, R::kNone, false},
      {"lan", "Lan et al. 2020", "mutual nearest neighbours, GMS, uniform samples, GMS once more on the inliers",
       M::kMutual, F::kGms, O::kNone, S::kUniform, V::kAll, R::kGms, false},
      {"gms_ransac", "Zhang et al. 2022", "GMS, then uniform samples from its survivors", M::kNearest, F::kGms,
       O::kNone, S::kUniform, V::kAll, R::kNone, false},
      {"cp_ransac", "the paper this package implements",
       "GMS, survivors sorted by neighbourhood score, samples from the most confident group first", M::kNearest,
       F::kGms, O::kMotionStatistics, S::kConfidenceGroups, V::kAll, R::kNone, false},
      {"fast", "this package",
       "GMS, spread samples of the most confident first, starts all over the sphere, local optimisation, refinement",
       M::kNearest, F::kGmsAdaptive, O::kMotionStatistics, S::kStratified, V::kBlockwise, R::kNone, false},
  };
  return table;
}

const Method& findMethod(const std::string& name) {
  std::string known;
  for (const Method& method : methods()) {
    if (name == method.name) return method;
    known += (known.empty() ? "" : ", ") + std::string(method.name);
  }
  throw std::invalid_argument("unknown method '" + name + "'; known are " + known);
}

ModelType parseModelType(const std::string& name) {
  for (ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    if (name == toString(model)) return model;
  }
  throw std::invalid_argument("unknown model '" + name + "'; known are essential, fundamental, homography");
}

std::string toString(ModelType model) {
  switch (model) {
    case ModelType::kEssential:
      return "essential";
    case ModelType::kFundamental:
      return "fundamental";
    case ModelType::kHomography:
      break;
  }
  return "homography";
}

}  // namespace gms_ransac
