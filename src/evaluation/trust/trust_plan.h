// What `evaluate trust` measures: pairs of data sets at some gaps, drawn pairs, and which truth they are held against.
#pragma once

#include <string>
#include <vector>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "trust/match_label.h"

namespace gms_ransac {

struct TrustSet {
  std::string path;
  TruthNoise noise;
};

struct TrustPlan {
  std::vector<TrustSet> sets;
  std::vector<int> gaps = {1};
  int stride = 1;
  std::vector<std::string> scenes;            ///< names of drawn ones
  int drawn_pairs = 100;                      ///< of each
  std::vector<MatchFilterOptions> pipelines;  ///< one for each method
  DatasetOptions dataset;
};

/// One piece of work: some neighbouring pairs of a set at a gap, or all pairs of a drawn scene.
struct TrustUnit {
  int index = 0;             ///< position in the plan, which orders the results
  int set = -1;              ///< into TrustPlan::sets; negative: drawn
  int scene = -1;            ///< into TrustPlan::scenes
  int gap = 0;               ///< 0: of a list of pairs
  int first = 0, count = 0;  ///< pairs
};

/// Units in order: set, gap, pairs; then scenes. Opens every set. Sets without a pair at a gap are named in `notes`.
std::vector<TrustUnit> trustUnits(const TrustPlan& plan, std::vector<std::string>& notes);

/// The sets that a folder is or holds, itself or its subfolders in the order of their names. Throws DatasetError where
/// there is none.
std::vector<std::string> setsIn(const std::string& folder);

/// The last part of a path, in small letters.
std::string setName(const std::string& path);

/// The noise of a data set's true motion from image to image, by what its name says of its kind (kitti, tum, freiburg,
/// 7scenes, euroc, rendered), else by its layout; doc/trust.md tells where the figures are from.
TruthNoise defaultTruthNoise(const std::string& path);

}  // namespace gms_ransac
