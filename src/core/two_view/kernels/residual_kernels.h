// The inner loops of estimation over all matches, one table of functions for each instruction set. All levels
// return the same bits: same operations in the same order, no fused multiply-add.
#pragma once

#include "gms_ransac/simd.h"
#include "two_view/kernels/point_columns.h"

namespace gms_ransac {

/// Score of one model; e is the squared residual over the squared threshold. `cost`: sum of min(e, 1) (MSAC, Torr &
/// Zisserman 2000) with the prior, `inliers`: number of e < 1.
struct HypothesisScore {
  float cost = 0;
  int inliers = 0;
  int evaluated = 0;  ///< matches looked at: less than all when the cost passed the bound
};

/// A pose X_current = R X_reference + t with its essential matrix E = [t]x R; row-major.
struct PoseParameters {
  float R[9], t[3], E[9];
};

/// Shape of the robust loss: matches with e >= cut are ignored, the others cost e / (1 + e / softness)
/// (Geman-McClure).
struct Loss {
  float cut = 1;
  float inverse_softness = 0;  ///< 0: plain truncated squares
};

/// Prior of the parallax d of a match: weight * ((1 + d^2 / s^2)^(1/4) - 1) is added to its cost. If poses explain the
/// matches equally well, the one with less parallax is likelier, as most of a scene is far.
struct ParallaxPrior {
  float weight = 0;         ///< in squared thresholds; 0: none
  float inverse_scale = 0;  ///< squared threshold over s^2
};

/// J^T W J (upper triangle by rows), J^T W r and the cost of a linearised model with P parameters.
template <int P>
struct NormalEquations {
  float matrix[P * (P + 1) / 2];
  float gradient[P];
  float cost;    ///< sum of the loss over all matches, those ignored at its value for e = cut
  float weight;  ///< sum of the loss's weights, about the number of inliers
};

/// The columns that ResidualKernels::differentiatePose fills: derivatives of the signed Sampson distance of each match,
/// in thresholds, and what its loss makes of them.
struct DerivativeColumn {
  enum : int {
    kRotation,         ///< about x, y and z
    kTranslation = 3,  ///< two steps of t along the basis
    kPoseCount = 5,
    kFocalLength = kPoseCount,  ///< relative
    kPrincipalPoint,            ///< x and y, focal lengths
    kRadialDistortion = 8,      ///< first coefficient
    kRowsReference,             ///< rotation about x, y and z per focal length of rows of the reference image
    kRowsCurrent = 12,          ///< the same of the current image
    kParameterCount = 15,
    kLineRotation = kParameterCount,  ///< angle by which either step of t rotates the epipolar line
    kPull = 17,                       ///< half the derivative of the loss by the residual
    kCount
  };
};

/// Sums over the matches that take part: those with weight, below the loss's cut and not near the epipole.
struct DerivativeSums {
  float curvature = 0;  ///< second derivatives of the loss, half
  int used = 0;
};

struct ResidualKernels {
  /// Sampson distance to x2^T M x1 = 0; stops once the cost exceeds `bound`.
  void (*scoreEpipolar)(const PointColumnsView& points, const float (&M)[9], float bound, HypothesisScore& score);
  /// The same for a pose. The residual of a match behind a camera is at least half the squared distance to infinity's
  /// projection.
  void (*scorePose)(const PointColumnsView& points, const PoseParameters& pose, const ParallaxPrior& prior, float bound,
                    HypothesisScore& score);
  /// Mean of the squared transfer distances of x2 ~ H x1, with G the inverse of H.
  void (*scoreHomography)(const PointColumnsView& points, const float (&H)[9], const float (&G)[9], float bound,
                          HypothesisScore& score);
  /// Linearised Sampson distance of a pose: rotation vector w of R <- exp(w) R, then steps of t along `basis`.
  void (*linearizePose)(const PointColumnsView& points, const PoseParameters& pose, const float (&basis)[2][3],
                        const Loss& loss, const ParallaxPrior& prior, NormalEquations<5>& equations);
  /// Derivatives of the residual of each match by pose and camera, doc/inside/judgement.md. `columns`: kCount times
  /// `size` entries, zero where a match takes no part.
  DerivativeSums (*differentiatePose)(const PointColumnsView& points, const PoseParameters& pose,
                                      const float (&basis)[2][3], const Loss& loss, float* columns);
  /// Sums over the slots of the products of the first kParameterCount of these columns with each other: the lower
  /// triangle by rows.
  void (*sumProducts)(const float* columns, int size, double* sums);
  /// Linearised Sampson distance; D[p] is the derivative of the matrix with respect to parameter p.
  void (*linearizeFundamental)(const PointColumnsView& points, const float (&F)[9], const float (&D)[7][9],
                               const Loss& loss, NormalEquations<7>& equations);
  /// Linearised transfer distance in the current image; D as above.
  void (*linearizeHomography)(const PointColumnsView& points, const float (&H)[9], const float (&D)[8][9],
                              const Loss& loss, NormalEquations<8>& equations);
  /// The same for the homography of a pure rotation, R <- exp(w) R.
  void (*linearizeRotation)(const PointColumnsView& points, const float (&R)[9], const Loss& loss,
                            NormalEquations<3>& equations);
  /// The costs of those normal equations alone, bit by bit.
  float (*poseCost)(const PointColumnsView& points, const PoseParameters& pose, const Loss& loss,
                    const ParallaxPrior& prior);
  float (*epipolarCost)(const PointColumnsView& points, const float (&M)[9], const Loss& loss);
  float (*transferCost)(const PointColumnsView& points, const float (&H)[9], const Loss& loss);
  /// e[i] of every slot i, padding included: Sampson distance, that of scorePose, transfer distance in the current
  /// image.
  void (*epipolarResiduals)(const PointColumnsView& points, const float (&M)[9], float* e);
  void (*poseResiduals)(const PointColumnsView& points, const PoseParameters& pose, float* e);
  void (*transferResiduals)(const PointColumnsView& points, const float (&H)[9], float* e);
  /// Functions of factor * x[i], for `size` entries of a column (its padding changes, too): the exponential, the
  /// natural logarithm of a positive number, the error function of one that is not negative.
  void (*exponential)(const float* x, float factor, int size, float* result);
  void (*logarithm)(const float* x, float factor, int size, float* result);
  void (*errorFunction)(const float* x, float factor, int size, float* result);
};

const ResidualKernels& residualKernels(SimdLevel level);

}  // namespace gms_ransac
