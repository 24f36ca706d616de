// Brute force for any processor.
#include "matching/hamming_rowwise.h"

namespace gms_ransac {
const HammingKernel kHammingKernelPortable = kRowwiseKernel;
}  // namespace gms_ransac
