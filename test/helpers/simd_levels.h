// The instruction sets of this processor.
#pragma once

#include <vector>

#include "gms_ransac/simd.h"

namespace gms_ransac {

inline std::vector<SimdLevel> supportedLevels() {
  std::vector<SimdLevel> levels;
  for (SimdLevel level : {SimdLevel::kScalar, SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (simdLevelSupported(level)) levels.push_back(level);
  }
  return levels;
}

}  // namespace gms_ransac
