// Draws minimal samples from the most confident matches first (PROSAC, Chum & Matas 2005), spread over the image.
#pragma once

#include <cstdint>
#include <vector>

#include "robust/random.h"

namespace gms_ransac {

/// Motion statistics are constant within a cell and highest in the densest texture, so the first matches of the order
/// lie close together; a sample of neighbours fixes a model badly. Members of a sample therefore come from distinct
/// cells of the spread grid, two of them at least a fifth of it apart, unless several attempts fail.
class StratifiedSampler {
 public:
  /// `order`: matches, most confident first (kept by reference); `cells`: cell of each match, by match.
  void begin(const std::vector<int>& order, const std::vector<int32_t>& cells, int sample_size);
  /// Fills `sample` with distinct matches of the current prefix, then widens the prefix.
  void draw(Random& random, int* sample);
  /// Length of the prefix the last draw was made from.
  int prefix() const { return drawn_from_; }

 private:
  bool spread(const int* sample) const;

  const std::vector<int>* order_ = nullptr;
  const std::vector<int32_t>* cells_ = nullptr;
  int sample_size_ = 0;
  double prefix_ = 0, growth_ = 1;
  int drawn_from_ = 0;
};

}  // namespace gms_ransac
