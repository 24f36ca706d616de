#include "judgement/probability.h"

#include <algorithm>
#include <cmath>

#include "two_view/translation_variance.h"

namespace gms_ransac {

namespace {

/// A row: evidence x makes a pose as likely as the logistic function of offset + slope * x, or of log(x).
struct Weight {
  Evidence kind;
  const char* name;
  bool logarithmic;
  double offset, slope;
  DirectionDoubt doubt;  ///< the word if it weighs most
};

// Any piece of evidence may rule a pose out, so the factors are multiplied.
// begin of the weights: scripts/fit_probability.py
constexpr Weight kOfPose[] = {
    {Evidence::kRotation, "rotation", false, 1.4, 0.515, DirectionDoubt::kRotationExplains},
    {Evidence::kStatic, "static", false, 5.29, -6.97, DirectionDoubt::kMostlyStatic},
    {Evidence::kInfinity, "infinity", false, 8.18, -14.3, DirectionDoubt::kMostlyStatic},
    {Evidence::kRotationSigma, "rotation_sigma", true, 2.24, -1.79, DirectionDoubt::kRotation},
    {Evidence::kDirectionSigma, "direction_sigma", true, 2.67, -1.1, DirectionDoubt::kDirection},
    {Evidence::kOtherMotion, "other_motion", false, 0.485, 1.9, DirectionDoubt::kOtherMotion},
    {Evidence::kSecondBody, "second_body", false, 7.4, -7.36, DirectionDoubt::kOtherMotion},
    {Evidence::kTorn, "torn", false, 4.38, -0.437, DirectionDoubt::kOtherMotion},
    {Evidence::kVotes, "votes", false, -1.58, 10.2, DirectionDoubt::kVotes},
    {Evidence::kUnconfirmed, "unconfirmed", true, 1.66, -0.975, DirectionDoubt::kUnconfirmed},
    {Evidence::kFixedToCamera, "fixed_to_camera", false, 2.92, -7.73, DirectionDoubt::kFixedToCamera},
};
constexpr Weight kOfRotation[] = {
    {Evidence::kRotationSpread, "rotation_spread", true, 3.71, -1.96, DirectionDoubt::kNone},
    {Evidence::kRotationVotes, "rotation_votes", false, -1.43, 9.68, DirectionDoubt::kNone},
    {Evidence::kSeen, "seen", false, 0.297, 9.99, DirectionDoubt::kNone},
    {Evidence::kInlierShare, "inlier_share", false, -1.58, 6.95, DirectionDoubt::kNone},
};
// end of the weights

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

/// The product of the factors of all evidence that there is. `weakest`: the word of the smallest factor.
template <size_t N>
double product(const Weight (&weights)[N], const EvidenceTable& evidence, DirectionDoubt* weakest = nullptr) {
  double probability = 1, least = 1;
  for (const Weight& weight : weights) {
    const double value = evidence[weight.kind];
    if (std::isnan(value)) continue;
    const double factor = logistic(weight.offset + weight.slope * (weight.logarithmic ? std::log(value) : value));
    probability *= factor;
    if (weakest != nullptr && factor < least) {
      least = factor;
      *weakest = weight.doubt;
    }
  }
  return probability;
}

}  // namespace

const char* toString(Evidence kind) {
  for (const Weight& weight : kOfPose) {
    if (weight.kind == kind) return weight.name;
  }
  for (const Weight& weight : kOfRotation) {
    if (weight.kind == kind) return weight.name;
  }
  return "";
}

void decide(const RobustOptions& options, Judgement& judgement) {
  EvidenceTable& evidence = judgement.evidence;
  const double variance = judgement.rotation.covariance.bottomRightCorner<3, 3>().trace();
  evidence[Evidence::kRotationSpread] = 180 / M_PI * std::sqrt(variance);
  DirectionDoubt weakest = DirectionDoubt::kNone;
  judgement.pose_probability = product(kOfPose, evidence, &weakest);
  // A right pose has a right rotation.
  const double without_translation = product(kOfRotation, evidence);
  const bool prefer_motion = judgement.pose_probability >= without_translation;
  judgement.rotation_probability = std::max(judgement.pose_probability, without_translation);
  judgement.translation_observable = judgement.pose_probability >= options.min_pose_probability;
  judgement.rotation_observable =
      judgement.translation_observable || judgement.rotation_probability >= options.min_rotation_probability;
  // A camera that only rotates sees everything static.
  if (weakest == DirectionDoubt::kMostlyStatic && evidence[Evidence::kRotation] < 0) {
    weakest = DirectionDoubt::kRotationExplains;
  }
  judgement.doubt = judgement.translation_observable ? DirectionDoubt::kNone : weakest;
  judgement.pose = prefer_motion || judgement.translation_observable ? judgement.motion : judgement.rotation;
  if (!judgement.translation_observable) setTranslationVariance(kAnyDirection, judgement.pose.covariance);
}

}  // namespace gms_ransac
