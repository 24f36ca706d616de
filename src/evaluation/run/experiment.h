// Runs pipelines over the pairs of a data set; every image is read and extracted once.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "run/record.h"

namespace gms_ransac {

/// One pipeline of an experiment. All pipelines of an experiment share the extractor's options.
struct Contender {
  MatchFilterOptions options;
  int repeat = 0;  ///< which repetition, for the record
};

/// One pipeline's answer to one pair, for as long as the call lasts.
struct Answer {
  const RecordContext& context;
  const Features &reference, &current;
  const Camera& camera;  ///< of both images; uncalibrated where the set has no intrinsics
  const MatchResult& result;
  const PairTruth& truth;
};

/// A sentence on what the options ask for and the set cannot give; nothing where it gives all.
std::optional<std::string> unappliedOption(const Dataset& dataset, const MatchFilterOptions& options);

class Experiment {
 public:
  /// Validates the options. `gap` goes into the records (0: pairs of a list).
  Experiment(const Dataset& dataset, const std::vector<Contender>& contenders, int gap);

  using Receiver = std::function<void(const Answer&)>;
  /// All contenders on one pair, in order. Throws DatasetError when an image cannot be read.
  void run(const DatasetPair& pair, const Receiver& receive);

 private:
  const Frame& frame(int index);
  void forgetFramesBefore(const DatasetPair& pair);

  const Dataset& dataset_;
  std::vector<Contender> contenders_;
  std::vector<std::unique_ptr<MatchFilter>> filters_;  ///< one for each contender; the first extracts
  int gap_;
  std::map<int, Frame> frames_;  ///< extracted and still needed
  Camera camera_;
  MatchResult result_;
};

}  // namespace gms_ransac
