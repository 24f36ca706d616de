// How strong the corners of a level are that become keypoints, forecast from the image before: weaker ones need not be
// looked for. A forecast says where to begin; that it holds for an image is checked in the image (CornerSelector).
#pragma once

namespace gms_ransac {

class StrengthForecast {
 public:
  /// A corner that is not stronger is not expected to become a keypoint. 0: nothing is known.
  int floor() const { return pause_ > 0 ? 0 : floor_; }

  /// The strength of the weakest keypoint of an image, 0 where every corner became one.
  void learn(int weakest) {
    floor_ = static_cast<int>(kShare * static_cast<float>(weakest));
    if (pause_ > 0) --pause_;
  }
  /// The floor was too high for an image, which was searched twice.
  void fail() { pause_ = kPause; }

 private:
  static constexpr float kShare = 0.85;  ///< the only one tried; holds for kitti_06 (doc/extractor.md)
  static constexpr int kPause = 8;       ///< images; bounds what images that are not alike cost
  int floor_ = 0;
  int pause_ = 0;
};

}  // namespace gms_ransac
