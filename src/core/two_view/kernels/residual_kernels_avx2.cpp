// The kernels for AVX2.
#if defined(__AVX2__)
#define GMS_RANSAC_VECTOR_BYTES 32
#include "two_view/kernels/residual_kernels_impl.h"

namespace gms_ransac {

const ResidualKernels& residualKernelsAvx2() { return Kernels::table(); }

}  // namespace gms_ransac

#endif
