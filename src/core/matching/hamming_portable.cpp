// Brute force for any processor, and the choice among the instruction sets.
#include "matching/hamming_rowwise.h"

namespace gms_ransac {

const HammingKernel kHammingKernelPortable = kRowwiseKernel;

const HammingKernel& hammingKernel([[maybe_unused]] SimdLevel level) {
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512) return kHammingKernelAvx512;
  if (level == SimdLevel::kAvx2) return kHammingKernelAvx2;
  if (__builtin_cpu_supports("popcnt")) return kHammingKernelPopcnt;
#elif defined(__aarch64__)
  if (level == SimdLevel::kNeon) return kHammingKernelNeon;
#endif
  return kHammingKernelPortable;
}

}  // namespace gms_ransac
