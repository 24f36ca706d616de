// The picture of one pair: matches drawn over the current image.
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

/// From purple (0) to yellow (1); brighter means more probable, for colour-blind eyes too. BGR, 0..255.
cv::Scalar probabilityColor(float probability);

/// BGR picture of the size of `grey` (CV_8UC1, the current image, dimmed; where `mask` is zero hatched, if it is not
/// empty): each inlier is a line from where the feature was in the reference to a dot where it is now, coloured from
/// purple (probability 0) to yellow (1); rejected matches are thin and grey. `caption` is one line of text at the top.
/// `result` may be null: caption only.
cv::Mat drawOverlay(const cv::Mat& grey, const cv::Mat& mask, const Frame* reference, const Frame* current,
                    const MatchResult* result, const std::string& caption);

}  // namespace gms_ransac
