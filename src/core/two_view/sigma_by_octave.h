// Standard deviations of thousands of points: one power an octave instead of one a keypoint.
#pragma once

#include <algorithm>
#include <array>

#include "gms_ransac/features.h"
#include "gms_ransac/robust_result.h"

namespace gms_ransac {

class SigmaByOctave {
 public:
  SigmaByOctave(const Judgement& judgement, float scale_factor)
      : aligned_(static_cast<float>(judgement.aligned_sigma_px)) {
    for (size_t octave = 0; octave < sigma_.size(); ++octave) {
      sigma_[octave] = static_cast<float>(judgement.sigma(static_cast<int>(octave), scale_factor));
    }
  }
  /// The nearest octave's where there is none of that number.
  float operator[](int octave) const {
    return sigma_[static_cast<size_t>(std::clamp(octave, 0, static_cast<int>(sigma_.size()) - 1))];
  }
  /// The same for a point that may be aligned.
  float of(int octave, bool aligned) const { return aligned ? aligned_ : (*this)[octave]; }

 private:
  std::array<float, Features::kOctaves> sigma_;
  float aligned_;
};

}  // namespace gms_ransac
