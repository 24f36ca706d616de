// The alignment of patches for AVX2.
#if defined(__x86_64__)
#define GMS_RANSAC_VECTOR_BYTES 32
#include "matching/patch_kernels_impl.h"

namespace gms_ransac {

const PatchKernels kPatchKernelsAvx2 = kKernels;

}  // namespace gms_ransac
#endif
