// The parts of the view that the stream has shown to be fixed to the camera.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/point_pairs.h"

namespace gms_ransac {

/// Cells of the spread grid in which keypoints stay in place while the camera moves, pair after pair: text, dust, a
/// bonnet, a gripper.
class LearnedMask {
 public:
  static constexpr size_t kCells = size_t{kSpreadGridSide} * kSpreadGridSide;

  LearnedMask() = default;
  explicit LearnedMask(const cv::Size& image) : image_(image) {}

  bool empty() const { return covered_ == 0; }
  /// Share of the cells that are covered, 0..1.
  double share() const { return static_cast<double>(covered_) / kCells; }
  const cv::Size& imageSize() const { return image_; }
  /// True if this pixel is not to be used.
  bool covers(const cv::Point2f& pixel) const { return !empty() && covers_[cellOf(pixel)] != 0; }
  /// True if this pixel is in a covered cell or next to one: what is fixed may reach there.
  bool touches(const cv::Point2f& pixel) const;
  /// CV_8UC1 in the size of the images, as FeatureExtractor::extract takes it: 0 where covered, else 255.
  cv::Mat toImage() const;
  /// `mask` (CV_8UC1, empty: none) without the covered cells, but for a peephole in each, which shows when it is no
  /// longer fixed; `mask` itself if nothing is covered or the image has another size.
  cv::Mat forExtraction(const cv::Mat& mask, const cv::Size& image) const;
  bool operator==(const LearnedMask& other) const { return image_ == other.image_ && covers_ == other.covers_; }
  bool operator!=(const LearnedMask& other) const { return !(*this == other); }

  size_t cellOf(const cv::Point2f& pixel) const { return static_cast<size_t>(spreadCell(pixel, image_)); }
  /// A pair has shown that a cell is fixed to the camera, or that it is not.
  void add(size_t cell, bool fixed);

 private:
  cv::Size image_;
  int covered_ = 0;
  std::array<int8_t, kCells> evidence_{};
  std::array<uint8_t, kCells> covers_{};
};

}  // namespace gms_ransac
