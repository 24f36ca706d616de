// Which instruction set the kernels use; chosen at run time, so that one binary serves every machine.
#pragma once

#include <string>

namespace gms_ransac {

enum class SimdLevel { kScalar, kNeon, kAvx2, kAvx512 };

/// The best level this processor supports, lowered to what the environment variable GMS_RANSAC_SIMD asks for
/// ("avx512", "avx2", "neon" or "scalar"; anything else, or a level the processor lacks, throws std::invalid_argument).
/// Read once per process. kAvx512 means F, BW, VL, DQ, VPOPCNTDQ, BITALG, VBMI and GFNI (Ice Lake, Zen 4); kAvx2
/// includes FMA, BMI2 and POPCNT.
SimdLevel detectSimdLevel();

/// True when this processor can execute code of that level.
bool simdLevelSupported(SimdLevel level);

std::string toString(SimdLevel level);

}  // namespace gms_ransac
