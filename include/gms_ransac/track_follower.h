// Follows chosen points on through images in which no keypoint was found, matched or judged an inlier where they are,
// and locates all of them to a fraction of a pixel.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/track_selector.h"

namespace gms_ransac {

/// The pairs say where a followed point is to be looked for: at the keypoint that carries its id on, else where its
/// neighbours went. There its surroundings are aligned with what they looked like when it was chosen, which gives a
/// position that does not drift. A point that moves other than the rest, by the epipolar geometry from the last image
/// to this one, is followed no further. Where the pair failed, the optical flow through an image pyramid says where to
/// look (cv::calcOpticalFlowPyrLK).
///
/// The images need not be consecutive: only those that are given to `follow`.
class TrackFollower {
 public:
  TrackFollower();
  ~TrackFollower();

  /// `image`: CV_8UC1, copied. `matched`: the features that TrackTable follows, with their pixels there. Returns the
  /// points that were kept and are seen in it, and behind them those of `matched` that are others and were not given up
  /// before. Nothing where `matched` is empty and the image shows next to none of the points: it counts
  /// as not given. Valid until the next call.
  const std::vector<TrackedPoint>& follow(const cv::Mat& image, const Camera& camera,
                                          const std::vector<TrackedPoint>& matched);
  /// Of what `follow` returned these (indices) are followed on, and no others. Not where it returned nothing.
  void keep(const std::vector<int>& picked);
  /// Nothing is followed any more.
  void reset();

  /// Of the points that were kept: those that `follow` found without a keypoint that carries the id on.
  int rescued() const { return rescued_; }

 private:
  struct Track;

  void predict(const std::vector<TrackedPoint>& matched);
  void predictByFlow(const cv::Mat& image);
  cv::Point2f flowAround(const cv::Point2f& pixel) const;
  void locate(const cv::Mat& image);
  void checkMotion(const Camera& camera);
  bool canBeTaken(const cv::Point2f& pixel) const;
  void report(const std::vector<TrackedPoint>& matched);

  /// Displacement of a feature since the last image.
  struct Flow {
    cv::Point2f from, by;
  };

  cv::Mat last_;  ///< image
  std::vector<Track> tracks_;
  std::unordered_map<uint32_t, cv::Point2f> seen_;  ///< pixels in the last image, of all that was returned
  std::unordered_set<uint32_t> given_up_;           ///< ids that may still be matched
  std::vector<Flow> flows_;
  std::vector<TrackedPoint> points_;
  int rescued_ = 0;
};

}  // namespace gms_ransac
