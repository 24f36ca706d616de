// The OpenCV baseline of the benchmark: the same stages made of OpenCV's parts, as visual front ends usually are.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/motion_statistics.h"
#include "methods/method.h"

namespace gms_ransac {

cv::Ptr<cv::ORB> makeBaselineExtractor(int features);
/// FAST contrast, grey levels, for that number of features: cv::ORB's default, or 0 where it does not give enough.
int fastThreshold(int features);

/// One of OpenCV's robust estimators. Threshold 1 px; RANSAC for a fundamental matrix with probability 0.99, for an
/// essential one 0.9999; at most 1000 samples each.
struct BaselineEstimator {
  std::string name;
  ModelType model;      ///< fundamental or essential
  int method;           ///< cv::RANSAC, cv::USAC_...
  bool sorted = false;  ///< wants the best matches first (lowest distance)
};

/// Those that this OpenCV has (USAC since 4.5); without a calibrated camera only the fundamental ones.
std::vector<BaselineEstimator> baselineEstimators(bool calibrated);

/// cv::BFMatcher's nearest neighbours.
std::vector<Match> baselineMatches(const cv::Mat& reference, const cv::Mat& current);

/// Motion statistics as the published implementations compute them: a dense count matrix, cleared, summed and searched
/// whole for each of the four grids of each run. The yardstick for the sparse filter's results and for its speed. Same
/// contract as MotionStatisticsFilter::compute, for a given (not an automatic) grid. Reference keypoints lie in or
/// beyond the right and lower border of their image, not before the left and upper one.
void denseMotionStatistics(const MotionStatisticsOptions& options, const Features& reference, const Features& current,
                           const std::vector<Match>& matches, MotionStatistics& statistics);

/// The matches that the statistics accept.
std::vector<Match> acceptedOf(const std::vector<Match>& matches, const MotionStatistics& statistics);

/// Returns the inlier mask; empty for too few matches or without a model. For an essential matrix `camera` undistorts
/// the points, and the pose is recovered, too. A sorted estimator sorts `matches`.
std::vector<uint8_t> estimate(const BaselineEstimator& estimator, const std::vector<cv::KeyPoint>& reference,
                              const std::vector<cv::KeyPoint>& current, const Camera& camera,
                              std::vector<Match>& matches);

}  // namespace gms_ransac
