// Evidence for and against the motion of a pair of images.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace gms_ransac {

/// Inputs of the probabilities of a pose and of its rotation, defined in doc/inside/judgement.md. The table in
/// src/core/judgement/probability.cpp has their names, weights and words.
enum class Evidence : uint8_t {
  // About the pose:
  kRotation,        ///< Vuong's statistic of the pose against a rotation, alone or with a rolling shutter
  kStatic,          ///< share of the inliers without parallax
  kInfinity,        ///< share of the inliers at infinity, under the pose's own rotation
  kRotationSigma,   ///< standard deviation of the rotation, degrees
  kDirectionSigma,  ///< standard deviation of the direction over RobustOptions::max_direction_sigma
  kOtherMotion,     ///< least statistic of the pose against another motion, over its limit
  kSecondBody,      ///< support of a second body, as a share of the pose's, where segmentation finds one
  kTorn,            ///< standard deviation of the direction by one side of a torn view alone, degrees
  kVotes,           ///< share of the cells whose distinctive matches lie on their epipolar lines
  kUnconfirmed,     ///< kDirectionSigma, where the pair before does not show the direction
  kFixedToCamera,   ///< probability that a part of the view is fixed to the camera
  // About the rotation:
  kRotationSpread,  ///< standard deviation of the rotation without a translation, degrees
  kRotationVotes,   ///< share of the cells whose distinctive matches agree with the rotation or with the pose
  kSeen,            ///< share of the cells of keypoints that have inliers
  kInlierShare,     ///< share of the matches that are inliers
  kCount
};

/// A number for each kind of evidence; NaN: none.
class EvidenceTable {
 public:
  static constexpr size_t kSize = static_cast<size_t>(Evidence::kCount);

  EvidenceTable() { values_.fill(std::numeric_limits<double>::quiet_NaN()); }
  double& operator[](Evidence kind) { return values_[static_cast<size_t>(kind)]; }
  double operator[](Evidence kind) const { return values_[static_cast<size_t>(kind)]; }

 private:
  std::array<double, kSize> values_;
};

/// The name of a kind of evidence, as in records.
const char* toString(Evidence kind);

}  // namespace gms_ransac
