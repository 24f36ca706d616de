// The alignment of patches for any processor, over vectors of 16 bytes.
#define GMS_RANSAC_VECTOR_BYTES 16
#include "matching/patch_kernels_impl.h"

namespace gms_ransac {

const PatchKernels kPatchKernelsScalar = kKernels;

const PatchKernels& patchKernels(SimdLevel level) {
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512) return kPatchKernelsAvx512;
  if (level == SimdLevel::kAvx2) return kPatchKernelsAvx2;
#endif
  static_cast<void>(level);  // NEON's vectors are those of 16 bytes
  return kPatchKernelsScalar;
}

}  // namespace gms_ransac
