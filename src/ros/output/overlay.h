// ~match_image: matches over the image, with a header for the outcome, a colour bar, and the last images'
// outcomes.
#pragma once

#include <cstdint>
#include <deque>

#include <opencv2/core/mat.hpp>

#include "parameters.h"
#include "stream/processed_frame.h"

namespace gms_ransac {

/// Colour of a quality from 0 (poor, purple) to 1 (good, yellow), BGR: a perceptual map, safe for the colour-blind.
cv::Scalar qualityColor(float quality);

/// Colour of a MatchStats status, BGR; black text on it is legible. From the palette of Okabe and Ito.
cv::Scalar statusColor(uint8_t status);

/// The pixels of a frame for people: BGR as they were received, grey where they have no known colours; empty: none.
cv::Mat receivedColours(const PreparedFrame& frame);

struct OverlayOptions {
  OverlayColour colour = OverlayColour::kResidual;
  OverlayLayout layout = OverlayLayout::kFlow;
};

class Overlay {
 public:
  static constexpr size_t kHistory = 200;  ///< images in the strip

  /// Remembers the outcome of an image for the strip.
  void add(const ProcessedFrame& processed);

  /// The picture, BGR. Images far from VGA are enlarged or reduced by a whole factor, so that text and lines are
  /// legible and the cost is bounded. Inliers are arrows from the reference position to a dot at the current one, the
  /// poorest on top; without inliers, or with OverlayColour::kStage, rejected matches are shown too. Masked parts are
  /// hatched.
  cv::Mat draw(const ProcessedFrame& processed, const OverlayOptions& options) const;

 private:
  struct Outcome {
    uint8_t status;
    float inlier_ratio;  ///< of the filtered matches
    float milliseconds;
  };

  std::deque<Outcome> history_;  ///< oldest first
};

}  // namespace gms_ransac
