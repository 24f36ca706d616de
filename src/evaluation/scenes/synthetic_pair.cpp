#include "scenes/synthetic_pair.h"

#include <algorithm>
#include <stdexcept>

#include <opencv2/core.hpp>

namespace gms_ransac {

namespace {

// Distances of correct and wrong nearest neighbours, bits: mean and deviation measured with cv::ORB and 2000 features
// on neighbouring frames of the room.
constexpr double kCorrectDistance = 27, kCorrectSpread = 14;
constexpr double kWrongDistance = 67, kWrongSpread = 8;
// Random pixels tried for each correct match before the two frames count as disjoint.
constexpr int kTriesPerMatch = 100;

uint16_t drawDistance(cv::RNG& rng, double mean, double spread) {
  return cv::saturate_cast<uint16_t>(std::clamp(mean + rng.gaussian(spread), 0.0, 256.0));
}

}  // namespace

SyntheticPair makeSyntheticPair(const Scene& scene, int reference, int current, const SyntheticPairOptions& options) {
  SyntheticPair pair;
  const cv::Size size = scene.options().size;
  pair.reference.image_size = pair.current.image_size = size;
  pair.correct.assign(options.matches, 1);
  const int wrong = cvRound(options.outlier_ratio * options.matches);
  std::fill_n(pair.correct.begin(), wrong, 0);
  cv::RNG rng(options.seed + 1);
  const auto random_pixel = [&] {
    const double x = rng.uniform(0.0, size.width - 1.0), y = rng.uniform(0.0, size.height - 1.0);
    return cv::Point2d(x, y);
  };
  for (int i = options.matches - 1; i > 0; --i) std::swap(pair.correct[i], pair.correct[rng.uniform(0, i + 1)]);

  for (int i = 0; i < options.matches; ++i) {
    cv::Point2d from = random_pixel(), to = random_pixel();
    if (pair.correct[i]) {
      int tries = 0;
      while (!scene.correspondence(reference, from, current, to)) {
        if (++tries == kTriesPerMatch) {
          throw std::invalid_argument("frames " + std::to_string(reference) + " and " + std::to_string(current) +
                                      " of the scene have too little in common");
        }
        from = random_pixel();
      }
      to.x = std::clamp(to.x + rng.gaussian(options.noise), 0.0, size.width - 1.0);
      to.y = std::clamp(to.y + rng.gaussian(options.noise), 0.0, size.height - 1.0);
    }
    pair.reference.keypoints.emplace_back(cv::Point2f(from), 31.f);
    pair.current.keypoints.emplace_back(cv::Point2f(to), 31.f);
    const uint16_t distance = pair.correct[i] ? drawDistance(rng, kCorrectDistance, kCorrectSpread)
                                              : drawDistance(rng, kWrongDistance, kWrongSpread);
    const uint16_t second = std::max(distance, drawDistance(rng, kWrongDistance, kWrongSpread));
    pair.matches.push_back({i, i, distance, second});
  }
  return pair;
}

}  // namespace gms_ransac
