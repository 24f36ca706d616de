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
#include "worker.h"

namespace gms_ransac {

class FastExtractor : public FeatureExtractor {
 public:
  explicit FastExtractor(const FeatureExtractorOptions& options);
  void extract(const cv::Mat& image, Features& features) override;

 private:
  struct Level {
    CornerDetector detector;
    CornerSelector selector;
    std::vector<Corner> corners;  ///< all of them, then the chosen ones
    double weight = 0;            ///< share of the features asked for
    int quota = 0;
    int first_keypoint = 0;
    Blur blur;
    Plane blurred;
  };

  /// Calls task(level) for every level of the image, on both threads if there are two.
  template <typename Task>
  void forEachLevel(const Task& task);
  /// Finds the corners of a level, the faint ones too if it has not enough others.
  void detect(int level);
  size_t cornerCount() const;
  /// Divides the features asked for among the levels, in proportion to their weights. What a level lacks in corners
  /// goes to the others.
  void setQuotas();
  void describe(int level, Features& features);
  /// Position in pixels of the level, by parabolas through the contrast of the corner and its neighbours, each
  /// smoothed across its direction.
  cv::Point2f refine(int level, const Corner& corner) const;

  FeatureExtractorOptions options_;
  const FeatureKernels& kernels_;
  Pyramid pyramid_;
  std::vector<Level> levels_;
  std::unique_ptr<Worker> worker_;
};

}  // namespace gms_ransac
