// Draws minimal samples from the most confident matches first (PROSAC, Chum & Matas 2005), spread over the image.
#pragma once

#include <cstdint>
#include <vector>

#include "ransac/sampler.h"

namespace gms_ransac {

/// Motion statistics are constant within a cell and highest in the densest texture, so the first matches of the order
/// lie close together; a sample of neighbours fixes a model badly. Members of a sample therefore come from distinct
/// cells of the spread grid, two of them at least a fifth of it apart, unless several attempts fail. Ends at the bound
/// from the inlier ratio of the prefix that samples come from, after at least kMinimumSamples.
class StratifiedSampler : public Sampler {
 public:
  /// To be called before begin(). `order`: columns, most confident first; `cells`: cell of each column. Both are kept
  /// by reference.
  void setCells(const std::vector<int>& order, const std::vector<int32_t>& cells);
  void begin(const SamplingTask& task) override;
  /// The same, with the first samples from this share of the matches.
  void begin(const SamplingTask& task, double first_share);
  /// Draws from the current prefix, then widens it.
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

  /// Length of the prefix the last draw was made from.
  int prefix() const { return drawn_from_; }

 private:
  int32_t cellOf(int rank) const;
  bool spread(const int* sample) const;
  /// Puts required_ at the bound for the present prefix.
  void updateBound();

  const std::vector<int>* order_ = nullptr;
  const std::vector<int32_t>* cells_ = nullptr;
  SamplingTask task_;
  double prefix_ = 0, growth_ = 1;
  int drawn_from_ = 0, bound_prefix_ = 0;
  int drawn_ = 0, required_ = 0;
  std::vector<uint8_t> inlier_;  ///< of the best hypothesis, by rank; empty: none yet
};

}  // namespace gms_ransac
