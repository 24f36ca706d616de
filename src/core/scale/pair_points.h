// The inliers of a pair of images as points in both of them, with depth and noise.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/triangulation.h"
#include "matching/patch.h"
#include "scale/joint_refinement.h"
#include "two_view/sigma_by_octave.h"

namespace gms_ransac {

/// A pair with depths at its keypoints.
struct DepthPair {
  const Triangulation& points;  ///< of its inliers
  const Features &reference, &current;
  const MatchResult& result;
  const Camera& camera;
  const std::vector<float>&reference_depth, &current_depth;  ///< metres, 0 where unknown; either may be empty
  /// Metres between two cameras, whose disparities may have a common offset; 0: a depth camera, whose rotation may grow
  /// with the row.
  double baseline;
  const std::vector<uint32_t>& track_ids;                          ///< one for each row of the result, 0: not followed
  cv::Mat reference_image = cv::Mat(), current_image = cv::Mat();  ///< CV_8UC1; empty: there are keypoints alone

  /// True for a depth camera until the stream has shown that its shutter is global: what it shows bends with the rows.
  bool mayRoll() const { return baseline == 0 && result.shutter.kind != Shutter::kGlobal; }
  bool hasPixels() const { return !reference_image.empty() && !current_image.empty(); }
};

/// Where the two images show a point.
struct Sighting {
  int point;           ///< its number in the pair's triangulation
  uint32_t track;      ///< 0: not followed
  cv::Point pixel;     ///< of the reference image
  PatchPlace current;  ///< of the patch around that pixel; where not `aligned`, what the keypoints say
  bool aligned;
};

/// Entry i of both is the same point.
struct PairPoints {
  std::vector<JointPoint> joint;
  std::vector<Sighting> sightings;
};

class PairReader {
 public:
  /// `pair` must outlive it.
  explicit PairReader(const DepthPair& pair);

  /// With pixels some inliers of every part of the image, aligned where their patches are found; else all, by their
  /// keypoints.
  PairPoints points() const;
  /// Metres, for a point of the triangulation; 0: not known.
  double referenceDepth(int point) const;
  double currentDepth(int point) const;
  /// Converts an aligned place of the current image.
  SeenPoint aligned(const PatchPlace& place, double depth) const;
  double pixel() const { return pixel_; }  ///< one, at depth 1

 private:
  const Match& match(int point) const { return pair_.result.matches[pair_.points.row[point]]; }
  uint32_t track(int point) const { return pair_.track_ids.empty() ? 0 : pair_.track_ids[pair_.points.row[point]]; }
  std::vector<int> chosen() const;
  double noise(const cv::KeyPoint& keypoint) const;
  /// `sigma`: of x and y at depth 1. `row`: pixels.
  SeenPoint seen(const Eigen::Vector2d& ray, double depth, double sigma, double row) const;

  const DepthPair& pair_;
  const double pixel_;
  const SigmaByOctave sigma_;
};

}  // namespace gms_ransac
