// Runs pipelines over the pairs of a data set; every image is read and extracted once.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "run/record.h"

namespace gms_ransac {

/// Tells the user on stderr the calibration in use and the options that do not apply to this set.
void printRemarks(const Dataset& dataset, const MatchFilterOptions& options);

class Experiment {
 public:
  /// The record of an answer, which names the pair, too; the answer, which a drawn scene has not, is valid during the
  /// call.
  using Receive = std::function<void(nlohmann::json& record, const Answer* answer)>;

  /// Validates the options. All pipelines share the extractor of the first.
  Experiment(const Dataset& dataset, const std::vector<MatchFilterOptions>& pipelines, const TruthNoise& noise);

  /// All pipelines on one pair, in order; a pair of a list has no `gap`. A pair whose reference was the current image
  /// of an earlier one continues that stream, with its past; any other stands alone. Throws DatasetError when an image
  /// cannot be read.
  void run(const DatasetPair& pair, int gap, const Receive& receive);

  /// For times that can be compared: extraction, matching and filter are the fastest of three rounds over the
  /// pipelines, so that a disturbance costs each at most one. Then the robust stage alone, by processor time, with
  /// `seeds` seeds from that of the pipelines on. Without a past.
  void time(const DatasetPair& pair, int gap, int seeds, const Receive& receive);

 private:
  const Frame& frame(int index, int rounds);
  /// Extracts what is missing, drops what is not needed any more, and sets the camera.
  PairTruth prepare(const DatasetPair& pair, int rounds);
  void tell(const DatasetPair& pair, int gap, const PairTruth& truth, const MatchFilterOptions& options,
            const MatchResult& result, const Receive& receive) const;

  const Dataset& dataset_;
  const TruthNoise noise_;
  const uint64_t first_seed_;  ///< that a record's `repeat` counts from
  std::vector<MatchFilter> filters_;
  std::map<int, Frame> frames_;             ///< extracted and still needed
  std::map<int, std::vector<Past>> pasts_;  ///< of each filter, by the current image of a pair
  Camera camera_;
  MatchResult result_;
};

}  // namespace gms_ransac
