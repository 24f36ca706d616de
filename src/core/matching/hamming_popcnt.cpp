// Brute force with the POPCNT instruction of x86-64 processors since 2008; compiled with -mpopcnt.
#include "matching/hamming_rowwise.h"

#if defined(__POPCNT__)
namespace gms_ransac {
const HammingKernel kHammingKernelPopcnt = kRowwiseKernel;
}  // namespace gms_ransac
#endif
