// The figures printed in the paper's Tables 1-5, to stand beside ours. Absolute counts and times are of another machine
// and of unnamed image pairs.
#pragma once

#include <string>

namespace gms_ransac {

struct PaperPreset {
  double matches = 0, milliseconds = 0;
};
/// Table 1; null for a preset the paper has not.
const PaperPreset* paperPreset(int preset);
/// Tables 2 and 3; zero matches for what the paper has not. `ratio` as "1/5".
PaperPreset paperRatio(int preset, const std::string& ratio);
/// Table 5, as text: the three sets (TUM desk, KITTI, TUM doll) and their mean; "-" for an unknown baseline.
std::string paperReduction(const std::string& baseline);

/// Range of "precision" in Table 4 for GMS-RANSAC and the paper's method, percent, with the digits its counts prove.
constexpr double kPaperLowestPrecision = 61.55, kPaperHighestPrecision = 81.95;

}  // namespace gms_ransac
