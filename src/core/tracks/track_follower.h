// Follows chosen points through images without their keypoint, and locates all to a fraction of a pixel.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "matching/patch.h"
#include "tracks/track_selector.h"

namespace gms_ransac {

/// Predicts a point from its keypoint, else from its neighbours, else by optical flow (cv::calcOpticalFlowPyrLK), then
/// aligns its patch with the first view, which does not drift. Points off the epipolar geometry are dropped. Works on
/// the images given to `follow` alone.
class TrackFollower {
 public:
  /// `image`: CV_8UC1, copied. `matched`: features of TrackTable, with their rows. Returns the kept points seen in it,
  /// then those of `matched` that are new. Empty if `matched` is and the image shows almost none of the points: it
  /// counts as not given. Valid until the next call.
  const std::vector<TrackedPoint>& follow(const cv::Mat& image, const Camera& camera,
                                          const std::vector<TrackedPoint>& matched);
  /// Keeps these points (indices of `follow`'s result) and no others.
  void keep(const std::vector<int>& picked);
  void reset();

 private:
  struct Track {
    TrackedPoint point;      ///< in the last image; from `locate` on in this one
    cv::Point2f last;        ///< pixel in the last image
    Patch patch;             ///< what it looked like when it was chosen
    PatchPlace place;        ///< of the patch, in the last image; from `locate` on in this one
    cv::Point2f prediction;  ///< pixel of this image
    float reach = 0;         ///< pixels about it that are searched
    bool alive = true;
  };

  void predict(const std::vector<TrackedPoint>& matched);
  void predictByFlow(const cv::Mat& image);
  cv::Point2f flowAround(const cv::Point2f& pixel) const;
  void locate(const cv::Mat& image);
  void checkMotion(const Camera& camera);
  void report(const std::vector<TrackedPoint>& matched);

  struct Flow {
    cv::Point2f from, by;
  };

  cv::Mat last_;  ///< image
  std::vector<Track> tracks_;
  std::unordered_map<uint32_t, cv::Point2f> seen_;  ///< pixels in the last image, of all that was returned
  std::unordered_set<uint32_t> given_up_;           ///< ids that may still be matched
  std::vector<Flow> flows_;
  std::vector<TrackedPoint> points_;
};

}  // namespace gms_ransac
