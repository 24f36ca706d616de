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
      // Textbook. Bound k = log(1 - p) / log(1 - w^n) from the best inlier ratio over all matches, no early exit.
      // Parameters of this and all: threshold_px, confidence, max_iterations, seed, refine.
      {"ransac", "Fischler & Bolles 1981", "uniform samples from all nearest neighbours", M::kNearest, F::kNone,
       O::kNone, S::kUniform, V::kAll, R::kNone, false},
      // T(d,d): a hypothesis is verified on all matches only if tdd_d random ones fit; a good one passes with w^d, so
      // the bound has n + d for n.
      {"rransac_tdd", "Matas & Chum 2004", "as ransac, but d random matches must fit before all are looked at",
       M::kNearest, F::kNone, O::kNone, S::kUniform, V::kTdd, R::kNone, false},
      // Growth function with T_N = 200000, non-randomness and maximality as in the paper, whose printed Algorithm 1 has
      // the branches of the draw exchanged (see ProsacSampler). Ordered by Hamming distance; quality selects another.
      {"prosac", "Chum & Matas 2005", "samples from growing prefixes of the matches of least descriptor distance",
       M::kNearest, F::kNone, O::kDescriptorDistance, S::kProsac, V::kAll, R::kNone, false},
      // The paper says no more than "random subsets on statistical ideas". Read as: subset_count independent subsets of
      // subset_fraction of the matches (at least twenty times the sample), RANSAC inside each with its own bound and an
      // equal share of max_iterations, the winner of lowest MSAC cost on all matches.
      {"subset_ransac", "Xu 2012", "ransac inside random subsets, the winner by its score on all matches", M::kNearest,
       F::kNone, O::kNone, S::kRandomSubsets, V::kAll, R::kNone, false},
      // Samples and bound from the first `split` of the matches by descriptor distance; support counted on the others,
      // ties by the first ("form a new sample set" is read as cross-validation). Inliers come from both.
      {"split2080", "Ci et al. 2022", "samples from the best fifth by descriptor distance, verified on the others",
       M::kNearest, F::kNone, O::kDescriptorDistance, S::kSplit, V::kHoldOut, R::kNone, false},
      // Bian's filter and nothing behind it. The pose comes from a uniform search whose model is always refined.
      {"gms", "Bian et al. 2017", "GMS alone: its survivors are the inliers, uniform samples give only the pose",
       M::kNearest, F::kGms, O::kNone, S::kUniform, V::kAll, R::kNone, true},
      // Centre, north, east, south and west; the threshold factor shrinks with the square root of 5/9.
      {"gms5", "Chen et al. 2018", "GMS alone with five cells that vote instead of nine", M::kNearest, F::kGmsFive,
       O::kNone, S::kUniform, V::kAll, R::kNone, true},
      // The criterion is not in the paper. Two readings, distance_reading: displacement against the neighbours' median
      // (default), or ratio of pairwise distances.
      {"gms_dist_ransac", "Zhu et al. 2019", "GMS, then matches that move as far as their neighbours, uniform samples",
       M::kNearest, F::kGmsDistance, O::kNone, S::kUniform, V::kAll, R::kNone, false},
      // Parameters lan_mutual and second_alpha; the second check thins its threshold as the matches were thinned.
      {"lan", "Lan et al. 2020", "mutual nearest neighbours, GMS, uniform samples, GMS once more on the inliers",
       M::kMutual, F::kGms, O::kNone, S::kUniform, V::kAll, R::kGms, false},
      // Only the abstract could be read. Textbook RANSAC on the survivors; "with the threshold" is read as an early
      // stop
      // at target_ratio, off by default. The baseline of the paper's 32 %.
      {"gms_ransac", "Zhang et al. 2022", "GMS, then uniform samples from its survivors", M::kNearest, F::kGms,
       O::kNone, S::kUniform, V::kAll, R::kNone, false},
      // Confidence groups: see ConfidenceGroupSampler. `ratio` is the share of the first group, geometric_groups widens
      // in steps; half of max_iterations may go into the first group. "Until the desired precision is achieved" is read
      // as: the bound from the inlier ratio of the group sampled from, with a support over all that is no chance. The
      // confidence is the neighbourhood score over its threshold; quality "score" takes the bare score, which is
      // highest
      // in the densest texture and gathers the samples there (kitti_06, neighbouring frames, five seeds: AUC5/10/20 of
      // 59.6/72.7/80.5 against 62.5/75.0/83.4).
      {"cp_ransac", "the paper this package implements",
       "GMS, survivors sorted by neighbourhood support, samples from the most confident group first", M::kNearest,
       F::kGms, O::kMotionStatistics, S::kConfidenceGroups, V::kAll, R::kNone, false},
      {"fast", "this package",
       "GMS, starts from all directions of translation, spread samples of the most distinctive first, refinement",
       M::kNearest, F::kGmsAdaptive, O::kDescriptorDistance, S::kStratified, V::kBlockwise, R::kNone, false},
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
