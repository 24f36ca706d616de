#include "gms_ransac/simd.h"

#include <cstdlib>
#include <stdexcept>

namespace gms_ransac {

bool simdLevelSupported(SimdLevel level) {
  switch (level) {
    case SimdLevel::kScalar:
      return true;
#if defined(__x86_64__)
    case SimdLevel::kAvx2:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2") &&
             __builtin_cpu_supports("popcnt");
    case SimdLevel::kAvx512:
      return simdLevelSupported(SimdLevel::kAvx2) && __builtin_cpu_supports("avx512f") &&
             __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vpopcntdq") &&
             __builtin_cpu_supports("avx512bitalg") && __builtin_cpu_supports("avx512vbmi") &&
             __builtin_cpu_supports("gfni");
#elif defined(__aarch64__)
    case SimdLevel::kNeon:
      return true;
#endif
    default:
      return false;
  }
}

std::string toString(SimdLevel level) {
  constexpr const char* kNames[] = {"scalar", "neon", "avx2", "avx512"};
  return kNames[static_cast<int>(level)];
}

namespace {

SimdLevel chooseLevel() {
  constexpr SimdLevel kBestFirst[] = {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kNeon, SimdLevel::kScalar};
  const char* wanted = std::getenv("GMS_RANSAC_SIMD");
  for (SimdLevel level : kBestFirst) {
    const bool asked = !wanted || !*wanted || toString(level) == wanted;
    if (asked && simdLevelSupported(level)) return level;
  }
  throw std::invalid_argument("GMS_RANSAC_SIMD=" + std::string(wanted) +
                              " is not a level this processor has: use avx512, avx2, neon or scalar, or unset it");
}

}  // namespace

SimdLevel detectSimdLevel() {
  static const SimdLevel level = chooseLevel();
  return level;
}

}  // namespace gms_ransac
