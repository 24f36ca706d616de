// Fourth stage, filtered matches -> robust model and pose: what goes in and what comes out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/relative_pose.h"
#include "gms_ransac/rotation_prior.h"
#include "gms_ransac/simd.h"

namespace gms_ransac {

/// Cells to a side of the grid on which matches count as neighbours. Its own, because the grid of the motion statistics
/// follows the number of matches and the user's wish; as many as the rules were measured with (doc/estimator.md).
constexpr int kSpreadGridSide = 20;
/// The cell of that grid that a pixel of an image lies in, row by row from 0; a pixel outside counts to the nearest.
int32_t spreadCell(const cv::Point2f& pixel, const cv::Size& image);

/// The matches that survived the filter, as columns of N entries.
struct PointPairs {
  std::vector<float> x_reference, y_reference;  ///< pixels of the ideal pinhole camera; of the image if uncalibrated
  std::vector<float> x_current, y_current;
  /// Pyramid levels: noise grows with them, as scale_factor^(octave / 2) (doc/estimator.md).
  std::vector<uint8_t> octave_reference, octave_current;
  std::vector<int32_t> score;                       ///< motion statistics score (0 where no filter ran)
  std::vector<float> relative_score;                ///< score / threshold (0 where no filter ran)
  std::vector<uint16_t> distance, second_distance;  ///< Hamming
  cv::Size image_reference, image_current;          ///< pixels; spread over the images is judged by them
  float scale_factor = 1.2f;
  std::optional<RotationPrior> rotation_prior;  ///< how the camera turned, where another sensor says so
  std::optional<double> seconds;                ///< from the reference to the current image, where that is known
  /// Of the images as they were received, where these are distorted and rows are read one after another; empty: y.
  std::vector<float> row_reference, row_current;

  int size() const { return static_cast<int>(x_reference.size()); }
  void resize(int n);
  /// False of a match with a coordinate that no keypoint has: not finite, or a million pixels and more from the origin.
  /// Estimators take it for an outlier.
  bool hasCoordinates(size_t i) const;
};

enum class ModelType { kEssential, kFundamental, kHomography };

/// "essential", "fundamental", "homography"; throws std::invalid_argument for another word.
ModelType parseModelType(const std::string& name);
std::string toString(ModelType model);

/// What makes a match trustworthy. Ties fall to the next key of: score (high), distance (low), Lowe ratio (low), index.
enum class SortKey {
  kScore,          ///< motion statistics: matches in support of it in the neighbourhood
  kRelativeScore,  ///< score over the threshold of its neighbourhood, which takes out the density of the texture
  kDistance,       ///< Hamming distance
  kLoweRatio,      ///< distance over second-nearest distance, in steps of 1/511
};

struct RobustOptions {
  ModelType model = ModelType::kEssential;
  std::optional<double> inlier_threshold_px;  ///< not set: 1 for essential and fundamental, 3 for homography
  double success_probability = 0.99;          ///< of having drawn a sample without outliers
  int max_iterations = 2000;                  ///< cap on samples
  uint64_t seed = 0;                          ///< same seed, same result
  double first_group_fraction =
      0.5;                        ///< cp_ransac: share of the matches in the first confidence group, the paper's ratio
  bool geometric_groups = false;  ///< cp_ransac: every further group that share of the rest, instead of one of all
  int tdd_d = 1;                  ///< rransac_tdd: matches tested before a full verification
  int subset_count = 5;           ///< subset_ransac: random subsets
  double subset_fraction = 0.2;   ///< subset_ransac: share of the matches in each
  double split_fraction = 0.2;    ///< split2080: share of the matches that are sampled; 1: all, and all verify
  std::optional<double> target_inlier_ratio;  ///< gms_ransac: stop at this inlier ratio
  std::optional<SortKey> sort_key;            ///< of methods that order the matches; not set: the method's own
  /// Whether the answer is judged: enough inliers that are spread, parallax, other motions that explain the matches as
  /// well. Off: the model that was found stands, as in the papers, and its covariance is that of the matches alone.
  bool judge = true;
  /// The direction of translation counts as known when its standard deviation, along its widest axis, is at most this:
  /// degrees, (0, 90]. 95 % of directions err by less than 2.45 of them.
  double max_direction_sigma = 10;
  double calibration_sigma = 0;  ///< relative uncertainty of the focal length, and of the principal point in focal
                                 ///< lengths: widens the covariance
  /// Seconds from the first row of an image to the last, which are read one after another; 0: all at once. Points are
  /// moved to where the camera would have seen them when it read the middle row (doc/uncertainty.md).
  double rolling_shutter_readout = 0;
  /// Robust least squares on the matches near the best model; off: textbook. `lo_prosac` always does.
  bool refine = true;
  SimdLevel simd = detectSimdLevel();

  double inlierThreshold() const;  ///< inlier_threshold_px with its default filled in
  /// Throws std::invalid_argument with a sentence that names the parameter, its value and its range
  /// (cfg/parameters.py).
  void validate() const;
};

/// What a camera model may get wrong.
enum class CameraParameter : uint8_t { kFocalLength, kPrincipalPoint, kRadialDistortion, kRollingShutter };

/// By how much a camera model seems to be wrong in each of its parameters alone, given less true, as one pair tells.
/// Over many pairs the mean tells more: what moves by itself pulls now this way and now that (doc/uncertainty.md).
struct CameraErrors {
  enum Parameter {
    kFocalLength,   ///< relative
    kPrincipalX,    ///< focal lengths
    kPrincipalY,    ///< focal lengths
    kRadial,        ///< first coefficient of the distortion
    kTurnWhileRead  ///< of that from image to image, share that goes on while a focal length's worth of rows is read
  };
  static constexpr size_t kCount = 5;

  std::array<double, kCount> value{};
  std::array<double, kCount> information{};  ///< inverse of the variance; 0: the pair tells nothing
};

/// Why a pair tells no direction of translation: the first of these that holds (doc/uncertainty.md).
enum class DirectionDoubt : uint8_t {
  kNone,
  kTurn,        ///< a turn explains the matches as well, alone or going on while rows are read
  kStill,       ///< most matches show no translation, and what does may move by itself
  kRotation,    ///< the rotation is known worse than to a degree
  kDirection,   ///< the direction is known worse than RobustOptions::max_direction_sigma
  kOtherMotion  ///< another motion explains the matches as well, or a second body nearly as many
};

/// By which turn the points of a pair were moved to where a camera that reads all rows at once would have seen them.
enum class RowCorrection : uint8_t {
  kNone,         ///< none: not asked for, or one that hardly moves a point
  kPair,         ///< that of the pair itself, at an even rate
  kPrior,        ///< rates that another sensor tells
  kUnknownTime,  ///< none: the time between the images is not known, or less than the readout
  kUnlikely      ///< none: the matches fit a motion better as they are
};

/// What an estimate cost.
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

struct RobustResult {
  bool model_found = false;
  ModelType model_type = ModelType::kEssential;
  /// x_current^T M x_reference = 0 (E: normalised coordinates; F: the pixels of PointPairs), or
  /// x_current ~ M x_reference (H: the pixels of PointPairs). Of the points as `row_correction` moved them.
  Eigen::Matrix3d model = Eigen::Matrix3d::Zero();
  std::vector<uint8_t> inlier;  ///< N entries; every inlier is within the threshold of `model`
  int inlier_count = 0;
  bool pose_found = false;              ///< needs a calibrated camera
  bool translation_observable = false;  ///< false: no direction known; `pose.t` is a guess (zero: none)
  DirectionDoubt doubt = DirectionDoubt::kNone;
  RelativePose pose;
  double median_parallax_px = 0;  ///< median over inliers of the displacement that no rotation undoes
  /// N entries, that a match is right; empty without a model. By residual and parallax under the pose, or where the
  /// camera is taken to have turned and no more by how far the match ends from where the turn takes it; without a pose
  /// by the residual alone, so that a wrong match which hits its epipolar line by chance passes for a right one.
  std::vector<float> probability;
  /// Estimated standard deviation of the coordinates of keypoints of level 0; 0 without a model.
  double sigma_px = 0;
  double noise_exponent = 0;  ///< how it grows with the level; 0: every keypoint has the same (see sigma)
  /// How far the residuals contradict the camera model: 1 is where chance alone would bring one pair in a hundred. And
  /// the parameter that they contradict most.
  double camera_misfit = 0;
  CameraParameter misfit_parameter = CameraParameter::kFocalLength;
  CameraErrors camera_errors;
  RowCorrection row_correction = RowCorrection::kNone;  ///< what RobustOptions::rolling_shutter_readout did
  double rms_error_px = 0;  ///< over inliers, of the model's residual (Sampson; transfer for a homography)
  Effort effort;

  /// Standard deviation of the coordinates of a keypoint, in pixels of the image without distortion: sigma_px
  /// scale_factor^(noise_exponent octave).
  double sigma(int octave, float scale_factor) const;
  /// Empties the result but keeps its storage.
  void clear();
  /// No model after all: no inliers and no pose. What the search cost stays.
  void reject();
};

}  // namespace gms_ransac
