// Where the current image shows what an earlier one shows at a point, to a tenth of a pixel: keypoints, found on levels
// of a pyramid, are half a pixel off.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "matching/patch.h"

namespace gms_ransac {

/// A pixel of an earlier image, whose grey levels are known without interpolation, and what the current one should
/// show.
struct PointToAlign {
  cv::Point pixel;
  PatchPlace guess;
};

/// The pixel at a keypoint; `guess` moves with it.
PointToAlign pointToAlign(const cv::Point2f& reference, const cv::Point2f& current, float magnification);

/// Of a keypoint in the image after its own: a change of shape must explain eight times what it would by chance (3 to
/// 20 make next to no difference), and what is found must look alike.
constexpr PatchSearch kInNextImage = {3, 0.93F, 8};
/// Of one whose patch was followed over more images, so that its shape is known.
constexpr PatchSearch kInLaterImage = {3};

/// Where `current` shows what `earlier` shows around the pixel; nothing if it does not look like it. CV_8UC1 both.
std::optional<PatchPlace> align(const cv::Mat& earlier, const cv::Mat& current, const PointToAlign& point,
                                const PatchSearch& search, SimdLevel simd = detectSimdLevel());

/// Indices of a few points from each cell of the image, so that crowded ones do not take the time of the others: those
/// that are followed for longest. `tracks`: id of each point, which count up; 0: not followed.
std::vector<int> spreadOut(const std::vector<cv::Point2f>& points, const std::vector<uint32_t>& tracks,
                           const cv::Size& size);

}  // namespace gms_ransac
