#include "past/mask_learner.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "past/pixel_motion.h"
#include "past/standstill.h"

namespace gms_ransac {

namespace {

// Pairs that cover a cell, the most that count, and what one that contradicts takes away.
constexpr int kCovered = 4, kMostEvidence = 6, kContradiction = 2;
/// A rotation moves the view from so many pixels on, and standard deviations of its own.
constexpr double kLeastRotation = 0.7, kSurely = 3;
constexpr double kStayed = 0.25, kMoved = 0.5;  ///< of the displacement by the rotation: a point below, above
constexpr double kOnLine = 4;                   ///< of a point that moved with the view, pixels (votes.cpp)
/// A cell is fixed if one of so many of its matches stayed: what is fixed ends within a cell.
constexpr int kOneOf = 5;
constexpr int kKeypointsToStay = 2;  ///< so many do not vanish from a cell that is fixed
constexpr double kMostOfView = 0.5;  ///< a mask over more is forgotten
constexpr int kPeepholeSide = 5;     ///< of a covered cell, the middle one of 5 x 5 parts has keypoints

/// How a motion moves the view, in pixels of the ideal camera.
class ViewMotion {
 public:
  ViewMotion(const Camera& camera, const Judgement& view)
      : motion_(camera, view.pose),
        translates_(view.translation_observable),
        surely_(kLeastRotation + kSurely * camera.meanFocalLength() *
                                     std::sqrt(view.pose.covariance.bottomRightCorner<3, 3>().trace())) {}

  /// Displacement of a point by the rotation, pixels; 0: it may be none.
  double rotated(const cv::Point2f& p) const {
    const double displacement = fromRotation(p, p);
    return displacement > surely_ ? displacement : 0;
  }
  /// No depth takes a point back that the rotation moves.
  bool excludesStaying(const cv::Point2f& p) const {
    return !translates_ || motion_.fromLine(p, p) > surely_ || motion_.isBehind(p, p);
  }
  bool explains(const cv::Point2f& p, const cv::Point2f& q) const {
    return translates_ ? motion_.fromLine(p, q) < kOnLine : fromRotation(p, q) < kMoved * fromRotation(p, p);
  }

 private:
  double fromRotation(const cv::Point2f& p, const cv::Point2f& q) const {
    return (motion_.toCurrent(p) - Eigen::Vector2d(q.x, q.y)).norm();
  }

  PixelMotion motion_;
  bool translates_;
  double surely_;
};

bool isStill(const cv::KeyPoint& from, const cv::KeyPoint& to, float scale_factor) {
  return cv::norm(to.pt - from.pt) < kMostMoved * std::pow(scale_factor, 0.5 * to.octave);
}

struct Cell {
  int still = 0, stayed = 0, moved = 0, keypoints = 0;  ///< stayed: those of `still` that the motion excludes
};

}  // namespace

cv::Mat LearnedMask::toImage() const {
  cv::Mat cells(kSpreadGridSide, kSpreadGridSide, CV_8UC1), image;
  std::transform(covers_.begin(), covers_.end(), cells.data, [](uint8_t covers) { return covers != 0 ? 0 : 255; });
  if (!image_.empty()) cv::resize(cells, image, image_, 0, 0, cv::INTER_NEAREST);
  return image;
}

cv::Mat LearnedMask::forExtraction(const cv::Mat& mask, const cv::Size& image) const {
  if (empty() || image != image_) return mask;
  cv::Mat fine, result;
  cv::resize(toImage(), fine, {kPeepholeSide * kSpreadGridSide, kPeepholeSide * kSpreadGridSide}, 0, 0,
             cv::INTER_NEAREST);
  for (int y = kPeepholeSide / 2; y < fine.rows; y += kPeepholeSide) {
    for (int x = kPeepholeSide / 2; x < fine.cols; x += kPeepholeSide) fine.at<uint8_t>(y, x) = 255;
  }
  cv::resize(fine, result, image, 0, 0, cv::INTER_NEAREST);
  if (!mask.empty()) cv::bitwise_and(result, mask, result);
  return result;
}

void LearnedMask::add(size_t cell, bool fixed) {
  int8_t& evidence = evidence_[cell];
  evidence =
      static_cast<int8_t>(std::clamp(fixed ? evidence + 1 : evidence - kContradiction, -kMostEvidence, kMostEvidence));
  if (evidence > 0 && evidence < kCovered) return;
  covered_ += (evidence > 0) - (covers_[cell] != 0);
  covers_[cell] = evidence > 0;
}

bool LearnedMask::touches(const cv::Point2f& pixel) const {
  const cv::Point2f cell(static_cast<float>(image_.width) / kSpreadGridSide,
                         static_cast<float>(image_.height) / kSpreadGridSide);
  for (const float y : {-1.f, 0.f, 1.f}) {
    for (const float x : {-1.f, 0.f, 1.f}) {
      if (covers({pixel.x + x * cell.x, pixel.y + y * cell.y})) return true;
    }
  }
  return false;
}

void leaveOutMasked(const Features& reference, const Features& current, MatchResult& result) {
  if (result.mask.empty()) return;
  const auto masked = [&](const Match& match) {
    const cv::KeyPoint& from = reference.keypoints[static_cast<size_t>(match.reference)];
    const cv::KeyPoint& to = current.keypoints[static_cast<size_t>(match.current)];
    const bool covered = result.mask.touches(from.pt) || result.mask.touches(to.pt);
    if (covered) result.masked.push_back(match);
    return covered;
  };
  result.raw.erase(std::remove_if(result.raw.begin(), result.raw.end(), masked), result.raw.end());
}

void learnMask(const Features& reference, const Features& current, const Camera& camera, const MatchResult& result,
               const Judgement& view, LearnedMask& mask) {
  if (!view.rotation_observable) return;
  std::array<Cell, LearnedMask::kCells> cells;
  const ViewMotion motion(camera, view);
  const auto count = [&](const Match& match) {
    const cv::KeyPoint& from = reference.keypoints[static_cast<size_t>(match.reference)];
    const cv::KeyPoint& to = current.keypoints[static_cast<size_t>(match.current)];
    const cv::Point2f p = camera.undistort(from.pt), q = camera.undistort(to.pt);
    const double rotated = motion.rotated(p), moved = std::hypot(q.x - p.x, q.y - p.y);
    if (rotated == 0) return;
    Cell& cell = cells[mask.cellOf(from.pt)];
    if (moved < kStayed * rotated && isStill(from, to, current.scale_factor)) {
      ++cell.still;
      cell.stayed += motion.excludesStaying(p);
    } else if (moved > kMoved * rotated) {
      cell.moved += motion.explains(p, q);
    }
  };
  for (const Match& match : result.raw) count(match);
  for (const Match& match : result.masked) count(match);
  for (const cv::KeyPoint& keypoint : reference.keypoints) {
    if (!mask.covers(keypoint.pt)) continue;
    cells[mask.cellOf(keypoint.pt)].keypoints += motion.rotated(camera.undistort(keypoint.pt)) > 0;
  }
  for (size_t k = 0; k < cells.size(); ++k) {
    const auto& [still, stayed, moved, keypoints] = cells[k];
    const bool gone = still == 0 && keypoints >= kKeypointsToStay;
    if (stayed > 0 || moved > 0 || gone) mask.add(k, stayed * kOneOf > moved + stayed);
  }
  if (mask.share() > kMostOfView) mask = LearnedMask(mask.imageSize());
}

}  // namespace gms_ransac
