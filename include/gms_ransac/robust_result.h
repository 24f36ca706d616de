// The result of a robust estimate: model, inliers, pose, and how far to trust them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/evidence.h"
#include "gms_ransac/relative_pose.h"
#include "gms_ransac/robust_options.h"
#include "gms_ransac/shutter.h"

namespace gms_ransac {

/// Parts of a camera model that may be wrong.
enum class CameraParameter : uint8_t { kFocalLength, kPrincipalPoint, kRadialDistortion, kRollingShutter };

/// Why the direction of translation is unknown: the evidence that weighed most (doc/inside/judgement.md).
enum class DirectionDoubt : uint8_t {
  kNone,
  kRotationExplains,  ///< a rotation explains the matches as well, alone or with a rolling shutter
  kMostlyStatic,      ///< most matches show no translation, the others may be a moving object
  kRotation,          ///< the rotation is known worse than to a degree
  kDirection,         ///< the direction is known worse than RobustOptions::max_direction_sigma
  kOtherMotion,       ///< another motion explains the matches as well, or a second body nearly as many
  kUnconfirmed,       ///< the pair before does not show it, and it is not known well enough to stand alone
  kFixedToCamera,     ///< a part of the view stays in place and the rest moves as one: either may be what is static
  kVotes              ///< distinctive matches all over the view do not agree with it
};

/// The rotation by which rolling-shutter points were corrected.
enum class RowCorrection : uint8_t {
  kNone,         ///< none: no readout is known, or it hardly moves a point
  kPair,         ///< that of the pair itself, and how it changed since the pair before
  kPrior,        ///< rates that another sensor tells
  kUnknownTime,  ///< none: the time between the images is not known, or less than the readout
  kUnlikely      ///< none: the matches fit a motion better as they are
};

/// Cost of an estimate.
struct Effort {
  int hypotheses = 0;             ///< minimal samples drawn
  int models_scored = 0;          ///< hypotheses that were verified
  int64_t point_evaluations = 0;  ///< residuals computed
  // Under a time limit alone:
  double search_seconds = 0;    ///< in samples
  bool search_cut = false;      ///< samples would have gone on
  bool refinement_cut = false;  ///< fewer steps than otherwise

  Effort& operator+=(const Effort& other);
};

/// The verdict on a pose, and on each match by that pose.
struct Judgement {
  bool pose_found = false;              ///< needs a calibrated camera
  bool translation_observable = false;  ///< false: no direction known; `pose.t` is a guess (zero: none)
  bool rotation_observable = false;     ///< false: `pose` is not fit to be published
  DirectionDoubt doubt = DirectionDoubt::kNone;
  RelativePose pose;    ///< published: `motion`, or without a known direction the more probable of both
  RelativePose motion;  ///< explains the matches best; filled for every status
  /// Rotation estimated without a direction of translation. Its t is a guess, the covariance of t has no meaning.
  RelativePose rotation;
  /// Probability that the motion is right (direction to 20 degrees, rotation to 3), and that the published rotation is.
  /// 0 without RobustOptions::judge.
  double pose_probability = 0, rotation_probability = 0;
  EvidenceTable evidence;  ///< from which both follow
  /// The rotation that explains the matches best by itself, as RelativePose::R.
  Eigen::Matrix3d rotation_alone = Eigen::Matrix3d::Identity();
  double median_parallax_px = 0;  ///< median over inliers of the displacement that no rotation undoes
  /// N entries, that a match is right; empty without a model. Without a pose by the residual alone, so that a wrong
  /// match on its epipolar line passes for right.
  std::vector<float> probability;
  /// N entries: residual that `probability` is computed from, in standard deviations; empty without a model.
  std::vector<float> residual;
  /// Estimated standard deviation of the coordinates of keypoints of level 0; 0 without a model.
  double sigma_px = 0;
  double aligned_sigma_px = 0;  ///< that of points that are aligned with each other; 0: unknown
  double noise_exponent = 0;    ///< how it grows with the level; 0: every keypoint has the same (see sigma)
  /// How far the residuals contradict the camera model, and the parameter that explains most of it. 1 is the 99 % point
  /// if noise were all; of real pairs with a good calibration 5 to 80 % lie above (doc/inside/judgement.md).
  double camera_misfit = 0;
  CameraParameter misfit_parameter = CameraParameter::kFocalLength;
  RowRates row_rates;  ///< for ShutterEstimate

  /// Drops everything but the storage.
  void clear();
  /// Standard deviation of a keypoint's coordinates, undistorted pixels: sigma_px scale_factor^(noise_exponent octave).
  double sigma(int octave, float scale_factor) const;
};

struct RobustResult {
  bool model_found = false;
  ModelType model_type = ModelType::kEssential;
  /// x_current^T M x_reference = 0 (E: normalised coordinates; F: pixels), or x_current ~ M x_reference (H: pixels).
  /// Points as `row_correction` moved them.
  Eigen::Matrix3d model = Eigen::Matrix3d::Zero();
  std::vector<uint8_t> inlier;  ///< N entries; every inlier is within the threshold of `model`
  int inlier_count = 0;
  RowCorrection row_correction = RowCorrection::kNone;  ///< what the readout of a rolling shutter did
  double readout = 0;  ///< by which the points were corrected, seconds for as many rows as the focal length has pixels
  double rms_error_px = 0;  ///< over inliers, of the model's residual (Sampson; transfer for a homography)
  Judgement judgement;
  std::optional<MotionStart> optimum;  ///< of the matches alone, where the next pair's search may start
  Effort effort;

  void clear();
  /// Drops model, inliers and pose; keeps the effort.
  void reject();
};

}  // namespace gms_ransac
