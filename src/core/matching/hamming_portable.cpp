// Brute force for any processor.
#include "matching/hamming_rowwise.h"

#include "matching/hamming_kernels.h"

namespace gms_ransac {

const HammingKernel kHammingKernelPortable = kRowwiseKernel;

const HammingKernel& hammingKernel(SimdLevel level) {
  switch (level) {
#if defined(__x86_64__)
    case SimdLevel::kAvx512:
      return kHammingKernelAvx512;
    case SimdLevel::kAvx2:
      return kHammingKernelAvx2;
    default:
      return __builtin_cpu_supports("popcnt") ? kHammingKernelPopcnt : kHammingKernelPortable;
#elif defined(__aarch64__)
    case SimdLevel::kNeon:
      return kHammingKernelNeon;
    default:
      return kHammingKernelPortable;
#else
    default:
      return kHammingKernelPortable;
#endif
  }
}

}  // namespace gms_ransac
