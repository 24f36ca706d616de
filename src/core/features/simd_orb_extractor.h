// Our ORB: the same descriptor as cv::ORB's on keypoints that are found faster, spread better and located more finely.
#pragma once

#include <memory>
#include <vector>

#include "features/blur.h"
#include "features/corner_detector.h"
#include "features/corner_selector.h"
#include "features/kernels.h"
#include "features/pyramid.h"
#include "features/strength_forecast.h"
#include "gms_ransac/feature_extractor.h"
#include "worker_pool.h"

namespace gms_ransac {

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

  /// What describing a level needs for a while. One for each thread instead of each level: it stays in the cache.
  struct Scratch {
    CornerSelector selector;
    Blur blur;
    Plane blurred;
    std::vector<cv::Point2f> directions;  ///< cosine and sine of each keypoint's angle
  };

  enum class Order { kLargestFirst, kSmallestFirst };

  /// Calls task(level, scratch) for every level of the image, on all threads. One thread keeps the order; several take
  /// the largest levels first, so that they end together.
  template <typename Task>
  void forEachLevel(Order order, const Task& task);
  /// Makes room in every scratch for the largest level, whichever thread takes it, so that later frames need none.
  void reserveScratch();
  /// Finds the corners of a level where `mask`, unless it is empty, lets it: those that may become keypoints, as the
  /// image before forecasts, or all.
  void detect(int level, const cv::Mat& mask);
  /// Finds all corners of a level, the faint ones too if it has not enough others.
  void detectAll(int level, const cv::Mat& mask);
  /// The same where corners were passed over that may become keypoints after all.
  void complete(int level, const cv::Mat& mask);
  /// Completes those of the incomplete levels of which `lacking` says so. False if there are none.
  template <typename Lacking>
  bool completeWhere(const cv::Mat& mask, const Lacking& lacking);
  void search(int level, const CornerFloors& floors, const cv::Mat& mask);
  void removeMasked(int level, const cv::Mat& mask);
  /// Whether a level has as many corners as its share of the features.
  bool hasEnough(const Level& level) const;
  bool isSparse(const cv::Mat& mask, size_t pixels);
  size_t cornerCount() const;
  /// Divides the features asked for among the levels, in proportion to their weights. What a level lacks in corners
  /// goes to the others.
  void setQuotas();
  /// Takes the best corners of a level.
  void select(int level, const cv::Mat& mask, CornerSelector& selector);
  void describe(int level, Scratch& scratch, Features& features);
  /// Fills in all of the keypoints of a level but their angles.
  void locate(int level, cv::KeyPoint* keypoints) const;
  /// Fills in the keypoints' angles, by the intensity centroid in `image`, and their directions.
  void orient(const Plane& image, const std::vector<Corner>& corners, cv::KeyPoint* keypoints,
              std::vector<cv::Point2f>& directions) const;
  /// Position in pixels of the level, by parabolas through the contrast of the corner and its neighbours, each
  /// smoothed across its direction.
  cv::Point2f refine(int level, const Corner& corner) const;
  /// The same in pixels of the image.
  cv::Point2f positionInImage(int level, const Corner& corner) const;

  FeatureExtractorOptions options_;
  const FeatureKernels& kernels_;
  Pyramid pyramid_;
  std::vector<Level> levels_;
  int wanted_ = 0;                    ///< keypoints of this image
  bool sparse_ = false;               ///< the image has few corners
  std::vector<Scratch> scratch_;      ///< of each thread
  std::shared_ptr<WorkerPool> pool_;  ///< where there are several
};

}  // namespace gms_ransac
