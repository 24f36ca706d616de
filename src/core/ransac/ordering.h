// Puts matches in order of confidence, for the samplers that try the best first.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_options.h"

namespace gms_ransac {

class Ordering {
 public:
  /// Fills `order` with the rows by rank, most confident first; without a key as they are.
  void sort(const PointPairs& pairs, std::optional<SortKey> key, std::vector<int>& order);

 private:
  struct Entry {
    uint32_t key;
    int row;
  };

  std::vector<Entry> entries_, scratch_;
};

}  // namespace gms_ransac
