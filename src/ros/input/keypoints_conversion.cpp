#include "input/keypoints_conversion.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

#include "gms_ransac/keypoints_view.h"
#include "guard.h"

namespace gms_ransac {

namespace {

// As many as ~features may ask for. All are compared with all.
constexpr size_t kMostKeypoints = 100000;

bool isMasked(const cv::Mat& mask, const cv::Point2f& point) {
  return mask.at<uint8_t>(std::clamp(cvRound(point.y), 0, mask.rows - 1),
                          std::clamp(cvRound(point.x), 0, mask.cols - 1)) == 0;
}

}  // namespace

std::string toFeatures(const Keypoints& message, Features& features) {
  features = Features();
  std::string problem;
  const auto convert = [&] {
    if (message.width == 0 || message.height == 0) {
      problem = "Keypoints: width or height is 0; they must be those of the image that the keypoints are of";
    } else if (message.u.size() > kMostKeypoints) {
      problem = "Keypoints: there are " + std::to_string(message.u.size()) + " keypoints; send at most " +
                std::to_string(kMostKeypoints);
    } else {
      features = KeypointsView<Keypoints>(message).features();
    }
  };
  guarded(convert, [&](const std::string& what) { problem = what; });
  return problem;
}

std::vector<float> depthOf(const Keypoints& message) {
  std::vector<float> depth = message.depth;
  for (float& metres : depth) metres = metres > 0 && std::isfinite(metres) ? metres : 0;
  return depth;
}

void dropMasked(const cv::Mat& mask, Features& features, std::vector<float>& depth) {
  if (mask.empty()) return;
  const cv::Mat all = features.descriptors.asMat();
  cv::Mat kept(0, all.cols, all.type());
  size_t count = 0;
  for (size_t i = 0; i < features.keypoints.size(); ++i) {
    if (isMasked(mask, features.keypoints[i].pt)) continue;
    kept.push_back(all.row(static_cast<int>(i)));
    if (!depth.empty()) depth[count] = depth[i];
    features.keypoints[count++] = features.keypoints[i];
  }
  features.keypoints.resize(count);
  if (!depth.empty()) depth.resize(count);
  features.descriptors.assign(kept);
}

}  // namespace gms_ransac
