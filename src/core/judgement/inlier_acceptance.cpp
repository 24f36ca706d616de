#include "judgement/inlier_acceptance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

namespace gms_ransac {

namespace {

// A spot is this share of the shorter side of the image away from the next (doc/measured/constants.md).
constexpr float kSpotDistance = 0.1f;
constexpr int kPoseFreedoms = 5, kCheckingSpots = 2, kMostSpots = kPoseFreedoms + kCheckingSpots;

/// True when so many of the inliers lie further apart than a spot, each from each, in one image.
bool spansSpots(const std::vector<float>& x, const std::vector<float>& y, const cv::Size& image,
                const std::vector<uint8_t>& inlier, int needed) {
  const float distance = kSpotDistance * static_cast<float>(std::min(image.width, image.height));
  std::array<cv::Point2f, kMostSpots> spots;
  int count = 0;
  for (size_t row = 0; row < inlier.size() && count < needed; ++row) {
    if (!inlier[row]) continue;
    const auto near = [&](const cv::Point2f& spot) {
      return std::max(std::abs(x[row] - spot.x), std::abs(y[row] - spot.y)) < distance;
    };
    if (std::none_of(spots.begin(), spots.begin() + count, near)) spots[count++] = {x[row], y[row]};
  }
  return count >= needed;
}

/// True when the inliers of one image lie on a line (or in a point) up to the threshold: such matches fit a whole
/// family of models, and the one found means nothing.
bool collinear(const std::vector<float>& x, const std::vector<float>& y, const std::vector<uint8_t>& inlier,
               double threshold_px) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  double n = 0;
  for (size_t row = 0; row < inlier.size(); ++row) {
    if (!inlier[row]) continue;
    const Eigen::Vector2d point(x[row], y[row]);
    sum += point;
    scatter += point * point.transpose();
    ++n;
  }
  scatter -= sum * sum.transpose() / n;
  const double half_trace = 0.5 * scatter.trace();
  const double smaller = half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - scatter.determinant()));
  return smaller < n * threshold_px * threshold_px;
}

}  // namespace

bool inliersAreAccepted(const PointPairs& pairs, int sample_size, double threshold_px, const RobustResult& result,
                        ChanceSupport& chance) {
  // Survivors of the filter come in groups of neighbours that move alike, so a spot in the image counts once however
  // many inliers it holds. As many as the sample has points, but no more than the five degrees of freedom of a relative
  // pose, determine the model; two more must check it. Poses of tum_fr3_cabinet from fewer spots are wrong with few
  // exceptions (doc/measured/constants.md).
  const int spots = std::min(sample_size, kPoseFreedoms) + kCheckingSpots;
  return result.inlier_count >= chance.minimum(sample_size, pairs.size()) &&
         (spansSpots(pairs.x_reference, pairs.y_reference, pairs.image_reference, result.inlier, spots) ||
          spansSpots(pairs.x_current, pairs.y_current, pairs.image_current, result.inlier, spots)) &&
         !collinear(pairs.x_reference, pairs.y_reference, result.inlier, threshold_px) &&
         !collinear(pairs.x_current, pairs.y_current, result.inlier, threshold_px);
}

}  // namespace gms_ransac
