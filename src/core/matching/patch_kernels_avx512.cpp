// The alignment of patches for AVX-512.
#if defined(__x86_64__)
#define GMS_RANSAC_VECTOR_BYTES 64
#include "matching/patch_kernels_impl.h"

namespace gms_ransac {

const PatchKernels kPatchKernelsAvx512 = kKernels;

}  // namespace gms_ransac
#endif
