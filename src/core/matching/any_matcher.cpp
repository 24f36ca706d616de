#include "matching/any_matcher.h"

#include <cmath>
#include <stdexcept>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

#include "matching/hamming_kernels.h"

namespace gms_ransac {

namespace {

constexpr double kBits = 8 * kDescriptorBytes;

/// Factor from a distance of cv::BFMatcher to one of 256 bits. Unrelated binary descriptors differ in half of their
/// bits, and perpendicular vectors are as unrelated, so L2 is measured in units in which they are 128 apart. The length
/// of a vector is the root mean square over both images.
double toBits(const cv::Mat& reference, const cv::Mat& current) {
  if (reference.type() == CV_8UC1) return kBits / (8. * reference.cols);
  const double squares = cv::norm(reference, cv::NORM_L2SQR) + cv::norm(current, cv::NORM_L2SQR);
  const double perpendicular = std::sqrt(2 * squares / (reference.rows + current.rows));
  return perpendicular > 0 ? kBits / 2 / perpendicular : 0;
}

}  // namespace

void matchMutually(const DescriptorSet& reference, const DescriptorSet& current, std::vector<Match>& matches) {
  matches.clear();
  if (!reference.comparableWith(current)) {
    throw std::invalid_argument("descriptors of " + reference.kind() + " cannot be compared with those of " +
                                current.kind() + "; use one detector for all images");
  }
  if (reference.size() == 0 || current.size() == 0) return;
  const cv::Mat queries = reference.asMat(), train = current.asMat();
  const cv::BFMatcher matcher(queries.type() == CV_8UC1 ? cv::NORM_HAMMING : cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> nearest, reverse;
  matcher.knnMatch(queries, train, nearest, 2);
  matcher.knnMatch(train, queries, reverse, 1);
  const double scale = toBits(queries, train);
  const auto bits = [&](const cv::DMatch& match) {
    const double distance = scale * static_cast<double>(match.distance);
    return static_cast<uint16_t>(distance < kBits ? std::lround(distance) : std::lround(kBits));  // kBits for NaN, too
  };
  for (const std::vector<cv::DMatch>& two : nearest) {
    if (two.empty()) continue;  // so far away that the distance is not finite
    const int i = two[0].queryIdx, j = two[0].trainIdx;
    const std::vector<cv::DMatch>& back = reverse[static_cast<size_t>(j)];
    if (back.empty() || back[0].trainIdx != i) continue;
    matches.push_back({i, j, bits(two[0]), two.size() > 1 ? bits(two[1]) : static_cast<uint16_t>(kNoDistance)});
  }
}

}  // namespace gms_ransac
