#include "scale/pair_points.h"

#include <algorithm>
#include <numeric>

#include "gms_ransac/point_pairs.h"
#include "matching/aligned_points.h"

namespace gms_ransac {

namespace {

// Least standard deviation of a keypoint, pixels: exact points have none.
constexpr double kLeastSigma = 0.05;
// Standard deviation of the inverse depth, 1/m: of a Kinect that moves (0.4 px of its disparity: neighbouring pixels
// err together, and depth is of another moment than colour), and if it is not known.
constexpr double kDepthImageSigma = 0.01, kNoDepthSigma = 1;
// Standard deviation of a disparity, pixels: its patches are aligned, so it does not share the noise of the keypoint.
constexpr double kDisparitySigma = 0.2;
// Standard deviation of an aligned point, pixels, and where a rolling shutter bends the image. The pixel that it is
// aligned with is exact. With 0.1 the motions of tum_fr1_rpy over ten images are three times as wrong as with 0.5.
constexpr double kAlignedSigma = 0.1, kAlignedSigmaRolling = 0.5;

cv::Point2f pointOf(const cv::Point& pixel) { return {static_cast<float>(pixel.x), static_cast<float>(pixel.y)}; }

}  // namespace

PairReader::PairReader(const DepthPair& pair)
    : pair_(pair),
      pixel_(1 / pair.camera.meanFocalLength()),
      sigma_(pair.result.robust.judgement, pair.current.scale_factor) {}

PairPoints PairReader::points() const {
  PairPoints points;
  for (const int point : chosen()) {
    const cv::KeyPoint &r = pair_.reference.keypoints[match(point).reference],
                       &c = pair_.current.keypoints[match(point).current];
    const double zr = referenceDepth(point), zc = currentDepth(point);
    const auto row = static_cast<size_t>(pair_.points.row[point]);
    PointToAlign place =
        pointToAlign(r.pt, pair_.result.current_pixel[row], zr > 0 && zc > 0 ? static_cast<float>(zr / zc) : 1);
    std::optional<PatchPlace> found;
    if (pair_.hasPixels() && pair_.result.pairs.isAligned(row)) {
      found = place.guess;
    } else if (pair_.hasPixels()) {
      found = align(pair_.reference_image, pair_.current_image, place, kInNextImage);
    }
    JointPoint joint;
    joint.cell = spreadCell(c.pt, pair_.current.image_size);
    if (found) {
      place.guess = *found;
      joint.reference = seen(rayOf(pair_.camera, pointOf(place.pixel)), zr, 0, place.pixel.y);
      joint.current = aligned(*found, zc);
    } else {
      joint.reference = seen({pair_.points.x_reference[point], pair_.points.y_reference[point]}, zr, noise(r), r.pt.y);
      joint.current = seen({pair_.points.x_current[point], pair_.points.y_current[point]}, zc, noise(c), c.pt.y);
    }
    points.joint.push_back(joint);
    points.sightings.push_back({point, track(point), place.pixel, place.guess, found.has_value()});
  }
  return points;
}

double PairReader::referenceDepth(int point) const {
  return pair_.reference_depth.empty() ? 0 : pair_.reference_depth[match(point).reference];
}

double PairReader::currentDepth(int point) const {
  return pair_.current_depth.empty() ? 0 : pair_.current_depth[match(point).current];
}

SeenPoint PairReader::aligned(const PatchPlace& place, double depth) const {
  const cv::Point2f pixel(place.centre.x(), place.centre.y());
  const double sigma = pair_.mayRoll() ? kAlignedSigmaRolling : kAlignedSigma;
  return seen(rayOf(pair_.camera, pixel), depth, sigma * pixel_, pixel.y);
}

std::vector<int> PairReader::chosen() const {
  std::vector<int> all(static_cast<size_t>(pair_.points.size()));
  std::iota(all.begin(), all.end(), 0);
  if (!pair_.hasPixels()) return all;
  std::vector<cv::Point2f> places;
  std::vector<uint32_t> tracks;
  for (const int point : all) {
    places.push_back(pair_.current.keypoints[match(point).current].pt);
    tracks.push_back(track(point));
  }
  return spreadOut(places, tracks, pair_.current.image_size);
}

double PairReader::noise(const cv::KeyPoint& keypoint) const {
  return pixel_ * std::max(kLeastSigma, static_cast<double>(sigma_[keypoint.octave]));
}

SeenPoint PairReader::seen(const Eigen::Vector2d& ray, double depth, double sigma, double row) const {
  const bool known = depth > 0;
  double depth_sigma = kNoDepthSigma;
  if (known) depth_sigma = pair_.baseline > 0 ? kDisparitySigma * pixel_ / pair_.baseline : kDepthImageSigma;
  const double variance = sigma * sigma;
  return {{ray.x(), ray.y(), known ? 1 / depth : 0},
          {variance, variance, depth_sigma * depth_sigma},
          known,
          row / pair_.current.image_size.height - 0.5};
}

}  // namespace gms_ransac
