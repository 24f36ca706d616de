// The matches that an estimator works on, as columns.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/types.hpp>

#include "gms_ransac/relative_pose.h"
#include "gms_ransac/shutter.h"

namespace gms_ransac {

/// Cells to a side of the grid on which matches count as neighbours.
constexpr int kSpreadGridSide = 20;
/// The cell of a pixel, row by row from 0; the nearest one for a pixel outside.
int32_t spreadCell(const cv::Point2f& pixel, const cv::Size& image);

/// The matches that survived the filter, as columns of N rows: those of MatchResult.
struct PointPairs {
  std::vector<float> x_reference, y_reference;  ///< pixels of the ideal pinhole camera; of the image if uncalibrated
  std::vector<float> x_current, y_current;
  /// Pyramid levels; noise grows as scale_factor^(octave / 2).
  std::vector<uint8_t> octave_reference, octave_current;
  /// Flags: the current point is where its image looks like the surroundings of the reference point, to a tenth of a
  /// pixel. Empty: none is.
  std::vector<uint8_t> aligned;
  std::vector<int32_t> score;                       ///< motion statistics score (0 where no filter ran)
  std::vector<float> relative_score;                ///< score / threshold (0 where no filter ran)
  std::vector<uint16_t> distance, second_distance;  ///< Hamming
  cv::Size image_reference, image_current;          ///< pixels; spread over the images is judged by them
  float scale_factor = 1.2f;
  std::optional<RotationPrior> rotation_prior;     ///< rotation from another sensor
  std::optional<MotionStart> previous_motion;      ///< of the pair before, a proposal
  Shutter shutter;                                 ///< as the stream has shown it
  std::optional<AngularVelocity> velocity_before;  ///< over the pair that ended at the reference
  std::optional<double> seconds;                   ///< from the reference to the current image, where that is known
  /// Image rows in the distorted images of a rolling shutter; empty: y.
  std::vector<float> row_reference, row_current;

  int size() const { return static_cast<int>(x_reference.size()); }
  bool isAligned(size_t row) const { return !aligned.empty() && aligned[row] != 0; }
  void resize(int n);
  /// Becomes the matches at `rows` of another object, in this order, with all else that is known of the pair.
  void gather(const PointPairs& all, const std::vector<int>& rows);
  /// False if a coordinate is not finite or a million pixels and more from the origin; such a match is an outlier.
  bool hasCoordinates(size_t row) const {
    constexpr float kFarthest = 1e6f;  // a fisheye lens of 10000 px reaches as far, 0.6 degrees short of a right angle
    const auto is_coordinate = [](float value) { return std::abs(value) < kFarthest; };  // nor NaN
    return is_coordinate(x_reference[row]) && is_coordinate(y_reference[row]) && is_coordinate(x_current[row]) &&
           is_coordinate(y_current[row]);
  }
};

}  // namespace gms_ransac
