// How well the matches determine a pose: their information on it and on the camera, summed over each cell of the image
// and over all; one covariance, and what other steps ask of it. Derived in doc/inside/judgement.md.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_result.h"
#include "gms_ransac/shutter.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// The partition of the image that the judgement works with: matches of one cell err together and count as one
/// observation.
constexpr int kCellSide = kSpreadGridSide, kCellCount = kCellSide * kCellSide;

constexpr int kPoseParameters = DerivativeColumn::kPoseCount;
constexpr int kParameters = DerivativeColumn::kParameterCount;
constexpr int kCameraParameters = kParameters - kPoseParameters;

using PoseVector = Eigen::Matrix<double, kPoseParameters, 1>;
using PoseSquare = Eigen::Matrix<double, kPoseParameters, kPoseParameters>;
using CameraVector = Eigen::Matrix<double, kCameraParameters, 1>;
using CameraSquare = Eigen::Matrix<double, kCameraParameters, kCameraParameters>;
using ParameterVector = Eigen::Matrix<double, kParameters, 1>;
using ParameterSquare = Eigen::Matrix<double, kParameters, kParameters>;

/// Blocks of cells to a side of the image.
constexpr int kBlockSide = 5, kBlockCount = kBlockSide * kBlockSide, kCellsOfBlock = kCellSide / kBlockSide;
static_assert(kCellSide % kBlockSide == 0, "blocks of whole cells");
constexpr int blockOf(int32_t cell) {
  return cell / kCellSide / kCellsOfBlock * kBlockSide + cell % kCellSide / kCellsOfBlock;
}

/// Typical calibration error (prior sigma) of each parameter: relative focal length, principal point in focal lengths,
/// first coefficient of radial distortion, rotation in radians per focal length of rows (doc/inside/judgement.md).
const CameraVector& typicalCameraError();

/// Inverse of a curvature by the pose; not finite where the matches do not suffice.
PoseSquare inverseOf(const PoseSquare& curvature);

/// Sums over the matches of one cell, or of one block, that take part. In single precision, which suffices for the few
/// matches of a part; row k of a product belongs to parameter k, and the last row is padding.
struct PartSums {
  /// Products of the derivatives of a match's residual with those by the pose and, in the last column, with its pull.
  using Products = Eigen::Matrix<float, kLanes, kPoseParameters + 1>;
  int32_t cell = 0;  ///< of a cell
  int count = 0;     ///< matches
  Products products = Products::Zero();

  /// Derivative of half the loss by all parameters, and its second derivatives by the pose over PoseInformation::bend.
  ParameterVector gradient() const { return products.col(kPoseParameters).head<kParameters>().cast<double>(); }
  PoseSquare ownProducts() const { return products.topLeftCorner<kPoseParameters, kPoseParameters>().cast<double>(); }
};

/// Parameters are those of PoseModel::linearize, then those of DerivativeColumn. Keeps its storage.
class PoseInformation {
 public:
  int used = 0;                    ///< matches that take part
  double bend = 1;                 ///< mean second derivative of half the loss by a residual
  ParameterVector gradient;        ///< derivative of half the loss, summed over all matches
  ParameterSquare curvature;       ///< second derivatives, the same
  ParameterSquare scatter;         ///< covariance of the gradient, from the cells (Liang & Zeger 1986)
  Eigen::Matrix2d line_rotations;  ///< products of the angles by which the two steps of t rotate the lines, summed
  std::vector<PartSums> cells;     ///< those with matches
  std::vector<PartSums> blocks;    ///< all of them

  /// Sums up the matches of a pair. `plausible`: the points, implausible ones without weight; `cells`: of each slot.
  void sum(const ResidualKernels& kernels, const PointColumnsView& plausible, const TwoViewPose& pose, const Loss& loss,
           const std::vector<int32_t>& cells);

  PoseSquare ofPose() const { return curvature.topLeftCorner<kPoseParameters, kPoseParameters>(); }
  /// Inverse of the curvature with the camera known to its typical errors. `variance`: of a residual.
  ParameterSquare inverseWithCamera(double variance) const;

 private:
  void sumParts(int count, const std::vector<int32_t>& cells);

  AlignedColumns columns_;  ///< DerivativeColumn
};

/// How far the matches contradict the camera model, and how far its errors may matter.
struct CameraTest {
  /// Largest score statistic over the 99 % point of its chi-square.
  double statistic = 0;
  CameraParameter parameter = CameraParameter::kFocalLength;  ///< the most contradicted
  RowRates rates;                                             ///< those of the readout
  /// Second moment of the parameters' errors, averaged over models of which parameters err; zero where the matches do
  /// not contradict them.
  CameraSquare second_moment = CameraSquare::Zero();
};

/// `inverse`: of the curvature by the pose, with noise counted as parallax: with the camera free, the direction is too
/// uncertain for the correction.
CameraTest testCamera(const PoseInformation& information, const PoseSquare& inverse);

/// First-order uncertainty of a pose in the parameters of PoseModel::linearize.
struct PoseCovariance {
  PoseSquare covariance = PoseSquare::Identity();  ///< what is published
  PoseSquare of_matches = PoseSquare::Identity();  ///< its part that assumes a perfect camera
  CameraTest camera;
};

/// `variance`: of the noise, squared thresholds; `calibration_sigma`: RobustOptions::calibration_sigma. Identity where
/// the matches do not suffice.
PoseCovariance poseCovariance(const PoseInformation& information, double variance, double calibration_sigma);

/// Standard deviation of the direction of translation along its widest axis, radians.
double directionSigma(const PoseSquare& covariance);

/// The covariance in the project's convention (see RelativePose).
Covariance6d relativeCovariance(const TwoViewPose& pose, const PoseSquare& covariance);

}  // namespace gms_ransac
