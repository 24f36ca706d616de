// Every method's estimator and the judgement, on every set of matches.
#include "fuzz_pairs.h"
#include "invariants.h"
#include "methods/method.h"

namespace gms_ransac {
namespace {

RobustOptions fuzzedOptions(FuzzInput& input) {
  RobustOptions options;
  options.model = static_cast<ModelType>(input.between(0, 2));
  if (input.flag()) options.inlier_threshold_px = input.byte() > 200 ? input.within(0.001, 100) : input.within(0.1, 5);
  options.success_probability = input.within(0.01, 0.999);
  options.max_iterations = input.between(1, 100);  // a fuzzer has no patience
  options.seed = input.byte();
  options.first_group_fraction = input.within(0.01, 1);
  options.geometric_groups = input.flag();
  options.tdd_d = input.between(1, 100);
  options.subset_count = input.between(1, 5);
  options.subset_fraction = input.within(0.01, 1);
  options.split_fraction = input.within(0.01, 1);
  if (input.flag()) options.target_inlier_ratio = input.within(0.01, 1);
  if (input.flag()) options.sort_key = static_cast<SortKey>(input.between(0, 3));
  options.judge = input.byte() < 192;
  options.max_direction_sigma = input.within(0.01, 90);
  options.calibration_sigma = input.flag() ? input.within(0, 0.2) : 0;
  options.refine = input.flag();
  return options;
}

PointPairs columnsOf(FuzzInput& input, const FuzzedPair& pair) {
  PointPairs pairs = pair.columns();
  if (input.byte() > 200) pairs.scale_factor = static_cast<float>(input.within(1.01, 2));
  Random random = input.random();
  const int highest_score = input.between(0, 200);
  for (size_t i = 0; i < pair.matches.size(); ++i) {
    pairs.score[i] = random.below(highest_score + 1);
    pairs.relative_score[i] = static_cast<float>(random.uniform() * highest_score);
  }
  return pairs;
}

/// The rolling shutter moves the points of the pair, so only the pose can be checked.
void checkRollingShutter(FuzzInput& input, MatchFilterOptions options) {
  options.robust.rolling_shutter_readout = input.within(0.001, 0.2);
  const FuzzedPair pair = fuzzedPair(input, 2000);
  PointPairs pairs = columnsOf(input, pair);
  pairs.seconds = input.number(-1, 1);
  pairs.rotation_prior.emplace();
  pairs.rotation_prior->rates.emplace();
  for (int k = 0; k < 3; ++k) {
    pairs.rotation_prior->rates->reference[k] = input.number(-10, 10);
    pairs.rotation_prior->rates->current[k] = input.number(-10, 10);
  }
  RobustResult result;
  makeMethod(options)->estimate(pairs, pair.camera, result);
  if (result.judgement.pose_found) demandEmpty(brokenPose(result.judgement.pose));
}

}  // namespace

void check(FuzzInput input) {
  MatchFilterOptions options;
  options.method = input.oneOf(methods()).name;
  options.robust = fuzzedOptions(input);
  options.validate();
  const std::unique_ptr<Method> method = makeMethod(options);
  RobustResult result;
  // Twice, since storage and what was learnt are kept from pair to pair.
  for (int i = 0; i < 2; ++i) {
    const FuzzedPair pair = fuzzedPair(input, 20000);
    const PointPairs pairs = columnsOf(input, pair);
    method->estimate(pairs, pair.camera, result);
    demandEmpty(brokenEstimate(pairs, pair.camera, options.robust, result));
  }
  if (input.flag()) checkRollingShutter(input, options);
}

}  // namespace gms_ransac
