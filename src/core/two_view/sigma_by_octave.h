// Judgement::sigma for thousands of keypoints: one power an octave instead of one a keypoint.
#pragma once

#include <algorithm>
#include <array>

#include "gms_ransac/features.h"
#include "gms_ransac/robust_result.h"

namespace gms_ransac {

class SigmaByOctave {
 public:
  SigmaByOctave(const Judgement& judgement, float scale_factor) {
    for (size_t octave = 0; octave < sigma_.size(); ++octave) {
      sigma_[octave] = static_cast<float>(judgement.sigma(static_cast<int>(octave), scale_factor));
    }
  }
  /// The nearest octave's where there is none of that number.
  float operator[](int octave) const {
    return sigma_[static_cast<size_t>(std::clamp(octave, 0, static_cast<int>(sigma_.size()) - 1))];
  }

 private:
  std::array<float, Features::kOctaves> sigma_;
};

}  // namespace gms_ransac
