#include "features/corner_selector.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gms_ransac {

namespace {
constexpr float kFeaturesPerCell = 5;
constexpr float kRankPower = 1;
constexpr int kRanks = 64;
constexpr int kShift = 4;

std::array<uint32_t, kRanks> makeRankWeights() {
  std::array<uint32_t, kRanks> w;
  for (int r = 0; r < kRanks; ++r) w[r] = std::lrint(256 * std::pow(r + 1.0, -kRankPower));
  return w;
}
}  // namespace

void CornerSelector::select(int width, int height, int quota, std::vector<Corner>& corners) {
  const int n = static_cast<int>(corners.size());
  if (n <= quota) return;
  static const auto weights = makeRankWeights();
  const float cell = std::max(8.f, std::sqrt(kFeaturesPerCell * width * height / std::max(quota, 1)));
  const int columns = std::max(1, static_cast<int>(width / cell)), rows = std::max(1, static_cast<int>(height / cell));
  const auto cellOf = [&](const Corner& c) { return (c.y * rows / height) * columns + c.x * columns / width; };

  cell_begin_.assign(columns * rows + 2, 0);
  for (const Corner& c : corners) ++cell_begin_[cellOf(c) + 2];
  for (size_t i = 2; i < cell_begin_.size(); ++i) cell_begin_[i] += cell_begin_[i - 1];
  ordered_.resize(n);
  for (int i = 0; i < n; ++i) {
    ordered_[cell_begin_[cellOf(corners[i]) + 1]++] = (255u - corners[i].contrast) << 24 | static_cast<uint32_t>(i);
  }
  priority_.assign(n, 0);
  histogram_.assign(65536 >> kShift, 0);
  for (int c = 0; c < columns * rows; ++c) {
    const auto begin = ordered_.begin() + cell_begin_[c], end = ordered_.begin() + cell_begin_[c + 1];
    std::sort(begin, end);
    for (auto it = begin; it != end; ++it) {
      const int rank = std::min<int>(it - begin, kRanks - 1);
      const uint32_t i = *it & 0xffffff;
      priority_[i] = static_cast<uint16_t>(corners[i].contrast * weights[rank] >> kShift);
      ++histogram_[priority_[i]];
    }
  }
  int cut = static_cast<int>(histogram_.size()) - 1, above = 0;
  while (above + static_cast<int>(histogram_[cut]) <= quota) above += histogram_[cut--];
  // Of the priority where the quota ends only some fit: every so many-th, so that they too are spread.
  const uint64_t need = quota - above, have = histogram_[cut];
  uint64_t seen = 0;
  int kept = 0;
  for (int i = 0; i < n; ++i) {
    bool keep = priority_[i] > cut;
    if (priority_[i] == cut) {
      keep = (seen + 1) * need / have > seen * need / have;
      ++seen;
    }
    if (keep) corners[kept++] = corners[i];
  }
  corners.resize(kept);
}

}  // namespace gms_ransac
