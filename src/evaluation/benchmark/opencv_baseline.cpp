#include "benchmark/opencv_baseline.h"

#include <algorithm>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/core/version.hpp>

namespace gms_ransac {

namespace {

constexpr double kThreshold = 1.0;  ///< pixels
constexpr double kFundamentalProbability = 0.99, kEssentialProbability = 0.9999;
constexpr int kMostSamples = 1000;  ///< findEssentialMat's own default where it cannot be given
constexpr int kUsualContrast = 20, kFeaturesAtUsualContrast = 3000;  ///< grey levels; cv::ORB's default

}  // namespace

int fastThreshold(int features) { return features > kFeaturesAtUsualContrast ? 0 : kUsualContrast; }

cv::Ptr<cv::ORB> makeBaselineExtractor(int features) {
  return cv::ORB::create(features, 1.2f, 8, 31, 0, 2, cv::ORB::HARRIS_SCORE, 31, fastThreshold(features));
}

std::vector<BaselineEstimator> baselineEstimators(bool calibrated) {
  std::vector<BaselineEstimator> all = {{"cv::findFundamentalMat RANSAC", ModelType::kFundamental, cv::FM_RANSAC}};
  if (calibrated) all.insert(all.begin(), {"cv::findEssentialMat RANSAC", ModelType::kEssential, cv::RANSAC});
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 5
  const ModelType model = calibrated ? ModelType::kEssential : ModelType::kFundamental;
  all.push_back({"cv USAC_PROSAC", model, cv::USAC_PROSAC, true});
  all.push_back({"cv USAC_ACCURATE", model, cv::USAC_ACCURATE});
  all.push_back({"cv USAC_MAGSAC", model, cv::USAC_MAGSAC});
#endif
  return all;
}

std::vector<Match> baselineMatches(const cv::Mat& reference, const cv::Mat& current) {
  std::vector<cv::DMatch> nearest;
  cv::BFMatcher(cv::NORM_HAMMING).match(reference, current, nearest);
  std::vector<Match> matches;
  matches.reserve(nearest.size());
  for (const cv::DMatch& m : nearest) matches.push_back({m.queryIdx, m.trainIdx, static_cast<uint16_t>(m.distance), 0});
  return matches;
}

std::vector<Match> acceptedOf(const std::vector<Match>& matches, const MotionStatistics& statistics) {
  std::vector<Match> accepted;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (statistics.accepted[i]) accepted.push_back(matches[i]);
  }
  return accepted;
}

std::vector<uint8_t> estimate(const BaselineEstimator& estimator, const std::vector<cv::KeyPoint>& reference,
                              const std::vector<cv::KeyPoint>& current, const Camera& camera,
                              std::vector<Match>& matches) {
  const auto closer = [](const Match& a, const Match& b) { return a.distance < b.distance; };
  if (estimator.sorted) std::stable_sort(matches.begin(), matches.end(), closer);
  const bool essential = estimator.model == ModelType::kEssential;
  std::vector<cv::Point2f> p, q;
  for (const Match& match : matches) {
    const cv::Point2f a = reference[match.reference].pt, b = current[match.current].pt;
    p.push_back(essential ? camera.undistort(a) : a);
    q.push_back(essential ? camera.undistort(b) : b);
  }
  std::vector<uint8_t> inlier;
  if (matches.size() < 8) return inlier;
  try {
    if (essential) {
      cv::Mat K, R, t;
      cv::eigen2cv(camera.K(), K);
      const cv::Mat E = cv::findEssentialMat(p, q, K, estimator.method, kEssentialProbability, kThreshold, inlier);
      if (E.rows != 3) return {};
      std::vector<uint8_t> in_front = inlier;
      cv::recoverPose(E, p, q, K, R, t, in_front);
    } else {
      const cv::Mat F =
          cv::findFundamentalMat(p, q, estimator.method, kThreshold, kFundamentalProbability, kMostSamples, inlier);
      if (F.empty()) return {};
    }
  } catch (const cv::Exception&) {
    return {};  // degenerate input is a failure of the baseline, not of the benchmark
  }
  return inlier;
}

}  // namespace gms_ransac
