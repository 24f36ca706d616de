// Every filter on every set of matches: the motion statistics in all their settings, the distance consistency behind
// them.
#include "fuzz_pairs.h"
#include "gms/distance_consistency.h"
#include "invariants.h"

namespace gms_ransac {
namespace {

MotionStatisticsOptions fuzzedOptions(FuzzInput& input) {
  MotionStatisticsOptions options;
  if (input.flag()) options.criterion = input.flag() ? Criterion::kEvidence : Criterion::kThreshold;
  if (input.flag()) options.grid_columns = input.between(2, 100);
  if (input.flag()) options.grid_rows = input.between(2, 100);
  if (input.flag()) options.threshold_factor = input.within(0.01, 100);
  options.rotation = input.flag();
  options.scale = input.flag();
  options.border = input.flag() ? GridBorder::kOriginal : GridBorder::kOpencv;
  options.neighborhood = input.flag() ? GridNeighborhood::kFive : GridNeighborhood::kNine;
  return options;
}

}  // namespace

void check(FuzzInput input) {
  const MotionStatisticsOptions options = fuzzedOptions(input);
  options.validate();
  MotionStatisticsFilter filter(options);
  const DistanceReading reading = input.flag() ? DistanceReading::kPairwise : DistanceReading::kDisplacement;
  const uint64_t seed = input.byte();
  MotionStatistics statistics;
  // Twice, since storage is kept from pair to pair.
  for (int i = 0; i < 2; ++i) {
    const FuzzedPair pair = fuzzedPair(input, 100000);
    const Features &reference = pair.reference.features, &current = pair.current.features;
    filter.compute(reference, current, pair.matches, statistics);
    demandEmpty(brokenStatistics(statistics, pair.matches.size()));
    const std::vector<uint8_t> before = statistics.accepted;
    rejectInconsistent(reading, seed, reference, current, pair.matches, statistics);
    for (size_t k = 0; k < before.size(); ++k) demand(statistics.accepted[k] <= before[k], "a filter only rejects");
    demandEmpty(brokenStatistics(statistics, pair.matches.size()));
  }
}

}  // namespace gms_ransac
