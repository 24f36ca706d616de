// The benchmark of what depends on the image before: whole frames of a sequence, and extraction at several image sizes.
#include "benchmark/benchmark_suite.h"

#include <utility>

#include "benchmark/dense_motion_statistics.h"
#include "benchmark/opencv_baseline.h"
#include "gms_ransac/match_filter.h"
#include "scenes/scene.h"

namespace gms_ransac {

namespace {

const char kFrames[] = "frame after frame", kBaselineExtractor[] = "cv::ORB";
constexpr int kImagesOfASize = 4;
constexpr double kSoftBlur = 2, kSoftNoise = 1;

/// cv::ORB, cv::BFMatcher, dense GMS and one of OpenCV's estimators; keeps the image before.
class BaselineChain {
 public:
  BaselineChain(int features, const Camera& camera)
      : camera_(camera),
        estimator_(baselineEstimators(camera.calibrated()).front()),
        extractor_(makeBaselineExtractor(features)) {}
  std::string name() const { return "OpenCV with " + estimator_.name; }

  /// Returns the number of inliers.
  int process(const cv::Mat& image) {
    cv::Mat descriptors;
    extractor_->detectAndCompute(image, cv::noArray(), current_.keypoints, descriptors);
    current_.image_size = image.size();
    int inliers = 0;
    if (!descriptors_.empty() && !descriptors.empty()) {
      std::vector<cv::DMatch> matches, survivors;
      cv::BFMatcher(cv::NORM_HAMMING).match(descriptors_, descriptors, matches);
      matches_.clear();
      for (const cv::DMatch& m : matches)
        matches_.push_back({m.queryIdx, m.trainIdx, static_cast<uint16_t>(m.distance), 0});
      denseMotionStatistics({}, reference_, current_, matches_, statistics_);
      for (size_t i = 0; i < matches.size(); ++i) {
        if (statistics_.accepted[i]) survivors.push_back(matches[i]);
      }
      for (const uint8_t inlier : estimate(estimator_, reference_.keypoints, current_.keypoints, camera_, survivors)) {
        inliers += inlier != 0;
      }
    }
    std::swap(reference_, current_);
    descriptors_ = descriptors;
    return inliers;
  }

 private:
  Camera camera_;
  BaselineEstimator estimator_;
  cv::Ptr<cv::ORB> extractor_;
  Features reference_, current_;
  cv::Mat descriptors_;  ///< of the reference
  std::vector<Match> matches_;
  MotionStatistics statistics_;
};

}  // namespace

void runFrames(const Dataset& dataset, int first, int count, const BenchmarkOptions& options, BenchmarkTable& table) {
  const StageClock clock(options.threads);
  std::vector<cv::Mat> images;
  for (int i = first; i < first + count; ++i) images.push_back(dataset.image(i));
  const Camera camera = dataset.intrinsics() ? Camera(*dataset.intrinsics(), images.front().size()) : Camera();
  // The first frame has nothing to be compared with, the second no motion before it.
  const auto run = [&](BenchmarkRow& row, const auto& process) {
    for (size_t i = 0; i < images.size(); ++i) {
      int inliers = 0;
      const double ms = clock.milliseconds([&] { inliers = process(images[i]); });
      if (i < 2) continue;
      row.ms.push_back(ms);
      row.count(inliers);
    }
  };
  for (int repeat = 0; repeat < options.repeat; ++repeat) {
    BaselineChain baseline(options.features, camera);
    run(table.row(kFrames, baseline.name()), [&](const cv::Mat& image) { return baseline.process(image); });
    for (const std::string& method : options.methods) {
      for (const SearchMode search : {SearchMode::kGuided, SearchMode::kFull}) {
        MatchFilter filter(options.pipeline(method, search));
        filter.setCamera(camera);
        const std::string name = method + (search == SearchMode::kFull ? ", full search" : "");
        run(table.row(kFrames, name, baseline.name()),
            [&](const cv::Mat& image) { return filter.process(image).inliers; });
      }
    }
  }
}

BenchmarkTable runSizes(const std::vector<cv::Size>& sizes, const BenchmarkOptions& options,
                        const std::function<void()>& size_done) {
  const StageClock clock(options.threads);
  cv::setNumThreads(options.threads);
  BenchmarkTable table;
  for (const cv::Size& size : sizes) {
    for (const bool soft : {false, true}) {
      SceneOptions scene;
      scene.size = size;
      if (soft) scene.blur = kSoftBlur, scene.noise = kSoftNoise;
      const Scene room(scene);
      std::vector<cv::Mat> images;
      images.reserve(kImagesOfASize);
      for (int i = 0; i < kImagesOfASize; ++i) images.push_back(room.render(i).image);
      const std::string stage = std::to_string(size.width) + "x" + std::to_string(size.height) + (soft ? ", soft" : "");
      const auto baseline = makeBaselineExtractor(options.features);
      const auto ours = makeFeatureExtractor(options.pipeline("", SearchMode::kFull).extractor);
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      Features features;
      for (int i = 0; i < kImagesOfASize * (options.repeat + 1); ++i) {
        const cv::Mat& image = images[static_cast<size_t>(i % kImagesOfASize)];
        const double baseline_ms =
            clock.milliseconds([&] { baseline->detectAndCompute(image, cv::noArray(), keypoints, descriptors); });
        const double ours_ms = clock.milliseconds([&] { ours->extract(image, features); });
        if (i < kImagesOfASize) continue;  // memory is allocated
        BenchmarkRow* rows[] = {&table.row(stage, kBaselineExtractor),
                                &table.row(stage, "simd_orb", kBaselineExtractor)};
        rows[0]->ms.push_back(baseline_ms);
        rows[0]->count(static_cast<int>(keypoints.size()));
        rows[1]->ms.push_back(ours_ms);
        rows[1]->count(features.size());
      }
    }
    size_done();
  }
  return table;
}

}  // namespace gms_ransac
