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
/// A displacement counts from so many pixels on, and standard deviations of its own.
constexpr double kLeast = 0.7, kSurely = 3;
/// The depth of many points undoes a smaller rotation, pixels, but for one of them (7scenes_redkitchen).
constexpr double kLeastRotation = 3;
constexpr double kStayed = 0.25, kMoved = 0.5;  ///< of the displacement by the rotation: a point below, above
/// A cell is fixed if one of so many of its matches stayed: what is fixed ends within a cell.
constexpr int kOneOf = 5;
constexpr int kKeypointsToStay = 2;  ///< so many do not vanish from a cell that is fixed
constexpr double kMostOfView = 0.5;  ///< a mask over more is forgotten
constexpr int kPeepholeSide = 5;     ///< of a covered cell, the middle one of 5 x 5 parts has keypoints

/// How a motion moves the view, in pixels of the ideal camera.
class ViewMotion {
 public:
  ViewMotion(const Camera& camera, const Judgement& view)
      : published_(camera, view.pose),
        motion_(camera, view.motion),
        translates_(view.translation_observable),
        surely_(kLeast + kSurely * camera.meanFocalLength() *
                             std::sqrt(view.pose.covariance.bottomRightCorner<3, 3>().trace())) {}

  /// Displacement of a point by the rotation, pixels; `rotated` below.
  double rotated(const cv::Point2f& p) const { return fromRotation(p, p); }
  bool isSure(double rotated) const { return rotated > surely_; }
  /// No depth takes a point back that the rotation moves.
  bool excludesStaying(const cv::Point2f& p, double rotated) const {
    if (isSure(rotated) && (!translates_ || motion_.isBehind(p, p))) return true;
    return rotated > std::min(surely_, kLeastRotation) &&
           motion_.fromLine(p, p) > kLeast + kSurely * motion_.fromLineSigma(p, p);
  }
  bool explains(const cv::Point2f& p, const cv::Point2f& q, double rotated) const {
    return translates_ ? motion_.fromLine(p, q) < kOnLine : fromRotation(p, q) < kMoved * rotated;
  }

 private:
  double fromRotation(const cv::Point2f& p, const cv::Point2f& q) const {
    return (published_.toCurrent(p) - Eigen::Vector2d(q.x, q.y)).norm();
  }

  PixelMotion published_, motion_;
  bool translates_;
  double surely_;
};

/// Tells matches that stay in place.
class Stillness {
 public:
  Stillness(const Features& reference, const Features& current) : reference_(reference), current_(current) {
    for (size_t octave = 0; octave < most_.size(); ++octave) {
      most_[octave] = kMostMoved * std::pow(current.scale_factor, 0.5f * static_cast<float>(octave));
    }
  }
  bool operator()(const Match& match) const {
    const cv::KeyPoint& to = current_.keypoints[static_cast<size_t>(match.current)];
    const cv::Point2f step = to.pt - reference_.keypoints[static_cast<size_t>(match.reference)].pt;
    const float most = most_[static_cast<size_t>(to.octave)];
    return step.dot(step) < most * most;
  }

 private:
  const Features &reference_, &current_;
  std::array<float, Features::kOctaves> most_;
};

struct Cell {
  int still = 0, stayed = 0, moved = 0, keypoints = 0;  ///< stayed: those of `still` that are of something fixed
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
  const Stillness isStill(reference, current);
  if (mask.empty() && std::none_of(result.raw.begin(), result.raw.end(), isStill)) return;
  std::array<Cell, LearnedMask::kCells> cells;
  const ViewMotion motion(camera, view);
  const auto count = [&](const Match& match) {
    const cv::Point2f& from = reference.keypoints[static_cast<size_t>(match.reference)].pt;
    const cv::Point2f p = camera.undistort(from);
    const cv::Point2f q = camera.undistort(current.keypoints[static_cast<size_t>(match.current)].pt);
    const double rotated = motion.rotated(p), moved = std::hypot(q.x - p.x, q.y - p.y);
    if (rotated < kLeast) return;
    Cell& cell = cells[mask.cellOf(from)];
    if (moved < kStayed * rotated && isStill(match)) {
      ++cell.still;
      // A match that stays next to a covered cell is of the same thing.
      cell.stayed += motion.excludesStaying(p, rotated) || (rotated > kLeastRotation && mask.touches(from));
    } else if (moved > kMoved * rotated) {
      cell.moved += motion.isSure(rotated) && motion.explains(p, q, rotated);
    }
  };
  for (const Match& match : result.raw) count(match);
  for (const Match& match : result.masked) count(match);
  for (const cv::KeyPoint& keypoint : reference.keypoints) {
    if (!mask.covers(keypoint.pt)) continue;
    cells[mask.cellOf(keypoint.pt)].keypoints += motion.isSure(motion.rotated(camera.undistort(keypoint.pt)));
  }
  for (size_t k = 0; k < cells.size(); ++k) {
    const auto& [still, stayed, moved, keypoints] = cells[k];
    const bool gone = still == 0 && keypoints >= kKeypointsToStay;
    const bool fixed = stayed * kOneOf > moved + stayed, moves = moved > 0 && moved + still >= still * kOneOf;
    if (fixed || moves || gone) mask.add(k, fixed);
  }
  if (mask.share() > kMostOfView) mask = LearnedMask(mask.imageSize());
}

}  // namespace gms_ransac
