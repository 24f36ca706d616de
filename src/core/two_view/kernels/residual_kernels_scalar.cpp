// The kernels for any processor, over vectors of four floats, and the choice among the instruction sets. The compiler
// translates them to what the processor has: SSE2 on x86, NEON on ARM, single numbers elsewhere.
#define GMS_RANSAC_VECTOR_BYTES 16
#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

const ResidualKernels& residualKernelsAvx2();
const ResidualKernels& residualKernelsAvx512();

const ResidualKernels& residualKernels([[maybe_unused]] SimdLevel level) {
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512) return residualKernelsAvx512();
  if (level == SimdLevel::kAvx2) return residualKernelsAvx2();
#endif
  return Kernels::table();
}

}  // namespace gms_ransac
