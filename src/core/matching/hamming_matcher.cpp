#include "gms_ransac/hamming_matcher.h"

#include <cstring>

#include "validation.h"

namespace gms_ransac {

namespace {
int hammingDistance(const uint8_t* a, const uint8_t* b) {
  int distance = 0;
  for (int i = 0; i < kDescriptorBytes; i += 8) {
    uint64_t x, y;
    std::memcpy(&x, a + i, 8);
    std::memcpy(&y, b + i, 8);
    distance += __builtin_popcountll(x ^ y);
  }
  return distance;
}
}  // namespace

void HammingMatcherOptions::validate() const { requireInRange("matcher_threads", threads, 1, 2); }

HammingMatcher::HammingMatcher(const HammingMatcherOptions& options) : options_(options) { options_.validate(); }

void HammingMatcher::match(const DescriptorSet& reference, const DescriptorSet& current, std::vector<Match>& matches) {
  matches.clear();
  if (current.size() == 0) return;
  for (int i = 0; i < reference.size(); ++i) {
    Match best{i, -1, 257, 257};
    for (int j = 0; j < current.size(); ++j) {
      const auto distance = static_cast<uint16_t>(hammingDistance(reference.row(i), current.row(j)));
      if (distance < best.distance) {
        best.second_distance = best.distance;
        best.distance = distance;
        best.current = j;
      } else if (distance < best.second_distance) {
        best.second_distance = distance;
      }
    }
    matches.push_back(best);
  }
}

}  // namespace gms_ransac
