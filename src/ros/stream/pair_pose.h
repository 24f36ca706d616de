// The relative pose of a comparison -> the pose that others may take: the length of its translation by ~scale, nothing
// invented, its covariance finite and bounded, and the last look at it.
#pragma once

#include <optional>
#include <string>

#include "gms_ransac/robust_result.h"
#include "two_view/translation_variance.h"

namespace gms_ransac {

struct ComparedPair;
struct Pipeline;
struct ProcessedFrame;
struct Stream;

/// Fills pose, length and points of an answer from its pair. Depth may change LOW_PARALLAX to OK; a pose that is
/// unfit to publish becomes RANSAC_FAILED with the reason. It updates scale and key frame of the stream.
void findPose(const Pipeline& pipeline, Stream& stream, ComparedPair& pair, ProcessedFrame& answer);

// robot_localization warns above the one and replaces a zero; anything in between is taken as it is.
constexpr double kLargestVariance = kUnknownTranslationVariance;
constexpr double kSmallestVariance = 1e-9;

/// Least standard deviations of a published pose, per axis.
struct SigmaFloor {
  double translation = 0.00004;  ///< as a share of its length
  double rotation = 0.00004;     ///< radians
};

/// Sets an unknown translation to zero with a large variance, adds the floors and bounds the diagonal to
/// [kSmallestVariance, kLargestVariance]. An invalid covariance (not finite, negative, not symmetric) stays as it is,
/// for poseDefect to find.
void makePublishable(bool translation_known, const SigmaFloor& floor, RelativePose& pose);

/// The likeliest motion under MOTION_UNKNOWN, for back ends that weigh it by its probability. Its translation has
/// length 1, its covariance none of the errors that all pairs share. None with another status, or if it is unfit to
/// publish.
std::optional<RelativePose> uncertainPose(const ProcessedFrame& answer, const SigmaFloor& floor);

/// The last check of a pose before it is published: why it must not be, or empty. Fit is one that is finite, with a
/// rotation matrix up to rounding and a covariance that is symmetric and positive definite.
std::string poseDefect(const RelativePose& pose);

/// Brings every entry of the diagonal into that range, makes the rest finite and the whole symmetric.
void boundCovariance(Covariance6d& covariance);

}  // namespace gms_ransac
