// Our ORB: the same descriptor as cv::ORB's on keypoints that are found faster, spread better and located more finely.
#pragma once

#include <memory>
#include <vector>

#include "features/blur.h"
#include "features/corner_detector.h"
#include "features/corner_selector.h"
#include "features/kernels.h"
#include "features/pyramid.h"
#include "gms_ransac/feature_extractor.h"
#include "worker_pool.h"

namespace gms_ransac {

class StrengthForecast {
 public:
  int floor() const { return pause_ > 0 ? 0 : floor_; }

  /// The strength of the weakest keypoint of an image, 0 where every corner became one.
  void learn(int weakest) {
    floor_ = static_cast<int>(kShare * static_cast<float>(weakest));
    if (pause_ > 0) --pause_;
  }
  /// The floor was too high for an image, which was searched twice.
  void fail() { pause_ = kPause; }

 private:
  static constexpr float kShare = 0.85;  ///< the only one tried; holds for kitti_06 (doc/extractor.md)
  static constexpr int kPause = 8;       ///< images; bounds what images that are not alike cost
  int floor_ = 0;
  int pause_ = 0;
};

class SimdOrbExtractor : public FeatureExtractor {
 public:
  explicit SimdOrbExtractor(const FeatureExtractorOptions& options);

 private:
  void extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) override;

  struct Level {
    CornerDetector detector;
    std::vector<Corner> corners;  ///< all of them, then the chosen ones
    double weight = 0;            ///< share of the features asked for
    StrengthForecast forecast;
    int strength_floor = 0;  ///< corners that are not stronger were passed over; 0: none were
    size_t met = 0;          ///< corners met, weaker ones included
    int quota = 0;
    int first_keypoint = 0;
  };

  /// Scratch storage for describing a level. One for each thread instead of each level: it stays in the cache.
  struct Scratch {
    CornerSelector selector;
    Blur blur;
    Plane blurred;
    std::vector<cv::Point2f> directions;  ///< cosine and sine of each keypoint's angle
  };

  enum class Order { kLargestFirst, kSmallestFirst };

  /// Calls task(level, scratch) for every level on all threads; several take the largest levels first.
  template <typename Task>
  void forEachLevel(Order order, const Task& task);
  /// Makes room in every scratch for the largest level, whichever thread takes it, so that later frames need none.
  void reserveScratch();
  /// Finds the corners of a level that may become keypoints, as the image before forecasts, or all.
  void detect(int level, const cv::Mat& mask);
  void detectAll(int level, const cv::Mat& mask);
  void complete(int level, const cv::Mat& mask);
  /// Completes those of the incomplete levels of which `lacking` says so. False if there are none.
  template <typename Lacking>
  bool completeWhere(const cv::Mat& mask, const Lacking& lacking);
  void search(int level, const CornerFloors& floors, const cv::Mat& mask);
  void removeMasked(int level, const cv::Mat& mask);
  bool hasEnough(const Level& level) const;
  bool isSparse(const cv::Mat& mask, const cv::Mat& image);
  size_t cornerCount() const;
  /// Divides the features among the levels by weight; what a level lacks goes to the others.
  void setQuotas();
  void select(int level, const cv::Mat& mask, CornerSelector& selector);
  void describe(int level, Scratch& scratch, Features& features);
  void locate(int level, cv::KeyPoint* keypoints) const;
  /// Fills in the keypoints' angles, by the intensity centroid in `image`, and their directions.
  void orient(const Plane& image, const std::vector<Corner>& corners, cv::KeyPoint* keypoints,
              std::vector<cv::Point2f>& directions) const;
  /// Position in pixels of the level, by parabolas through the smoothed contrasts around the corner.
  cv::Point2f refine(int level, const Corner& corner) const;
  cv::Point2f positionInImage(int level, const Corner& corner) const;

  FeatureExtractorOptions options_;
  const FeatureKernels& kernels_;
  Pyramid pyramid_;
  std::vector<Level> levels_;
  int wanted_ = 0;                ///< keypoints of this image
  bool sparse_ = false;           ///< the image has few corners
  std::vector<Scratch> scratch_;  ///< of each thread
  std::shared_ptr<WorkerPool> pool_;
};

}  // namespace gms_ransac
