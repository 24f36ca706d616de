// Series of image pairs, of a data set or drawn: a record for each pair and pipeline. Every command goes through
// series; those of `evaluate odometry` are of single images.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter_options.h"
#include "program.h"
#include "run/truth.h"
#include "scenes/drawn_scenes.h"
#include "scenes/drawn_sequences.h"

namespace gms_ransac {

using Pipelines = std::vector<MatchFilterOptions>;

using Records = std::vector<nlohmann::json>;

/// Pairs, measured one after the other.
struct Series {
  std::string name;
  size_t count;
  /// Makes what measures a pair: its records, by pipeline. Throws DatasetError when an image cannot be read.
  std::function<std::function<Records(size_t pair)>()> begin;
  size_t lead = 0;  ///< pairs to measure before the first one, whose past they are

  /// Gives the records of the pairs from the first up to the last to `receive`, until that returns false.
  void measure(size_t first, size_t last, const std::function<bool(Records&)>& receive) const;
};

struct MeasuredSet {
  Dataset dataset;
  TruthNoise noise;
};

// Sets, scenes and pipelines have to outlive their series. All pipelines share the extractor of the first.

/// Every `stride`-th pair of a set whose images are `gap` apart. Every image is read and extracted once. A pair whose
/// reference was the current image of an earlier one continues that stream, with its past; any other stands alone.
/// `correspondences`: the records have them.
Series pairSeries(const MeasuredSet& set, int gap, int stride, const Pipelines& pipelines, bool correspondences);

/// Pairs spread over a set, with times that can be compared: extraction, matching and filter are the fastest of three
/// rounds over the pipelines, so that a disturbance costs each at most one. Then the robust stage alone, by processor
/// time, with `seeds` seeds. Without a past.
Series timedSeries(const MeasuredSet& set, int gap, int pairs, const Pipelines& pipelines, int seeds);

/// Pairs of a drawn scene, for the estimators alone.
Series drawnSeries(const DrawnScene& scene, int pairs, const Pipelines& pipelines);

/// Pairs of neighbours in drawn sequences of that name, as many whole ones as `pairs` make but at least one; each is a
/// stream.
Series sequenceSeries(const DrawnSequence& sequence, int pairs, const Pipelines& pipelines);

/// Drawn pairs of a general motion with that share of outliers anywhere; the seed of scene and estimator counts up.
Series outlierSeries(double outlier_ratio, int pairs, const Pipelines& pipelines);

/// Gives all records to a reporter with these arguments and `out`, with a line of progress, until Ctrl-C. `unit`:
/// "pair", "image". Returns the exit status.
int stream(const std::vector<Series>& all, const std::string& unit, const std::vector<std::string>& report,
           const std::string& out = "");

}  // namespace gms_ransac
