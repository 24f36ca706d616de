// The inner loops of the alignment of patches, one table of functions for each instruction set. All levels compute the
// same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gms_ransac/simd.h"

namespace gms_ransac {

constexpr int kPatchRadius = 5;  ///< pixels
constexpr int kPatchSide = 2 * kPatchRadius + 1, kPatchLanes = 16;

/// One number for each pixel of a patch, in its first kPatchSide columns; zero in the others.
struct PatchNumbers {
  float at[kPatchSide][kPatchLanes];
};

/// An offset d from the centre of a patch lies at (x, y) + shape d.
struct PatchMap {
  float x, y;
  float shape[2][2];

  bool upright() const { return shape[0][0] == 1 && shape[0][1] == 0 && shape[1][0] == 0 && shape[1][1] == 1; }
};

/// Sums over the pixels, each times 1, x, y and so on, the offset from the centre.
struct PatchMoments {
  float one, x, y, xx, xy, yy;
};

constexpr int kRowPatchWidth = 11, kRowPatchHeight = 9;  ///< of the grey levels that are aligned along a row
constexpr int kRowShifts = 5;                            ///< at which they are compared, a pixel apart
constexpr int kRowPixels = kRowPatchWidth + kRowShifts;  ///< read of a row
constexpr uint16_t kWholeRow = 256;

struct PixelRows {
  const uint8_t* first;
  ptrdiff_t stride;
};

/// Sums over the patch of the left image, of its gradients along the row (differences over two pixels), of the right
/// image at each shift and without one, and of the products of two.
struct RowSums {
  int gradient, own;
  int gradient_gradient, own_own, middle_middle, gradient_own;
  int there[kRowShifts], gradient_there[kRowShifts];
};

struct PatchKernels {
  /// Grey levels, bilinear. All pixels must lie in the image, whose right and lower neighbours are read.
  void (*sample)(const uint8_t* image, ptrdiff_t stride, const PatchMap& place, PatchNumbers& levels);
  /// The same with how much the levels differ to both sides. The pixels around the patch must lie in the image, too.
  void (*sampleWithDifferences)(const uint8_t* image, ptrdiff_t stride, const PatchMap& place, PatchNumbers& levels,
                                PatchNumbers& across, PatchNumbers& down);
  /// To mean 0 and length 1; returns the length before. Leaves zeros where they are all alike.
  float (*normalize)(PatchNumbers& levels);
  /// Sum of the products of both.
  float (*product)(const PatchNumbers& a, const PatchNumbers& b);
  /// The same for products with the coordinates.
  PatchMoments (*moments)(const PatchNumbers& a, const PatchNumbers& b);
  /// `left`: from the column before the patch; `right`: at the first shift, lower by `below` of kWholeRow. Reads
  /// kRowPixels of a row, and a row more of the right image if it is lower.
  RowSums (*sumRows)(const PixelRows& left, const PixelRows& right, uint16_t below);
};

const PatchKernels& patchKernels(SimdLevel level);

// Defined where the target has them; use patchKernels().
extern const PatchKernels kPatchKernelsScalar, kPatchKernelsAvx2, kPatchKernelsAvx512;

}  // namespace gms_ransac
