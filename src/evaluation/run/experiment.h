// Runs pipelines over the pairs of a data set; every image is read and extracted once.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "run/pair_truth.h"

namespace gms_ransac {

/// One pipeline's answer to one pair, valid during the call.
struct Answer {
  size_t pipeline;  ///< index into those of the experiment
  const MatchFilterOptions& options;
  const Features &reference, &current;
  const Camera& camera;  ///< of both images; uncalibrated where the set has no intrinsics
  const MatchResult& result;
  const PairTruth& truth;
};

/// Tells the user on stderr the calibration in use and the options that do not apply to this set.
void printRemarks(const Dataset& dataset, const MatchFilterOptions& options);

/// The fields of a record that name a pair. `gap` is null for pairs of a list.
nlohmann::json pairRecord(const Dataset& dataset, const DatasetPair& pair, int gap);

class Experiment {
 public:
  /// Validates the options. All pipelines share the extractor of the first.
  Experiment(const Dataset& dataset, const std::vector<MatchFilterOptions>& pipelines);

  /// All pipelines on one pair, in order. A pair whose reference was the current image of an earlier one continues that
  /// stream, with its past; any other stands alone. Throws DatasetError when an image cannot be read.
  void run(const DatasetPair& pair, const std::function<void(const Answer&)>& receive);

 private:
  const Frame& frame(int index);

  const Dataset& dataset_;
  std::vector<MatchFilter> filters_;
  std::map<int, Frame> frames_;             ///< extracted and still needed
  std::map<int, std::vector<Past>> pasts_;  ///< of each filter, by the current image of a pair
  Camera camera_;
  MatchResult result_;
};

}  // namespace gms_ransac
