// The instruction set of the kernels, chosen at run time.
#pragma once

#include <string>

namespace gms_ransac {

enum class SimdLevel { kScalar, kNeon, kAvx2, kAvx512 };

/// The best level of this processor, lowered to the environment variable GMS_RANSAC_SIMD ("avx512", "avx2", "neon",
/// "scalar"; anything else throws std::invalid_argument). Read once. kAvx512: F, BW, VL, DQ, VPOPCNTDQ, BITALG, VBMI,
/// GFNI; kAvx2 includes FMA, BMI2, POPCNT.
SimdLevel detectSimdLevel();

bool simdLevelSupported(SimdLevel level);

std::string toString(SimdLevel level);

}  // namespace gms_ransac
