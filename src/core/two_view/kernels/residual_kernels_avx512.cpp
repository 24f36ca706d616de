// The kernels for AVX-512.
#if defined(__AVX512F__)
#define GMS_RANSAC_VECTOR_BYTES 64
#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

const ResidualKernels& residualKernelsAvx512() { return Kernels::table(); }

}  // namespace gms_ransac

#endif
