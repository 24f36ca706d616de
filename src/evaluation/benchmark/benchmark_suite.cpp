#include "benchmark/benchmark_suite.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <utility>

#include "benchmark/opencv_baseline.h"
#include "gms/guided_search.h"
#include "gms_ransac/match_filter.h"
#include "program.h"
#include "run/truth.h"

namespace gms_ransac {

namespace {

using nlohmann::json;

const char kMatch[] = "match", kGms[] = "GMS", kGmsAll[] = "GMS, rotation + scale", kEstimate[] = "estimate",
           kFilter[] = "match + GMS + estimate", kFrame[] = "whole frame", kFrames[] = "frame after frame";
const char kBaselineMatcher[] = "cv::BFMatcher", kBaselineGms[] = "dense GMS", kBaselineExtractor[] = "cv::ORB";

struct ExtractorContender {
  std::string name;
  std::unique_ptr<FeatureExtractor> extractor;
  Frame reference, current;
  double ms = 0;  ///< last extraction of the current image
};

/// Our matcher at one instruction set, with train descriptors packed for it.
struct MatcherContender {
  std::string name;
  SimdLevel level;
  HammingMatcher matcher;
};

/// Our pipeline with one extractor and one method.
struct FilterContender {
  std::string name;
  const ExtractorContender& extractor;
  MatchFilter filter;
  MatchResult result;
};

std::string chainName(const BaselineEstimator& estimator) { return "OpenCV with " + estimator.name; }

class Suite {
 public:
  Suite(const Dataset& dataset, const BenchmarkOptions& options)
      : dataset_(dataset),
        options_(options),
        baseline_extractor_(makeBaselineExtractor(options.features)),
        same_pyramid_(makeFeatureExtractor(samePyramid())),
        guided_search_({false, options.threads}, {}) {
    for (SimdLevel level : {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kNeon, SimdLevel::kScalar}) {
      if (!simdLevelSupported(level)) continue;
      for (const bool mutual : {false, true}) {
        matchers_.push_back({toString(level) + (mutual ? ", mutual" : ""), level,
                             HammingMatcher(HammingMatcherOptions{mutual, options.threads, level})});
      }
    }
    for (ExtractorContender& with : extractors_) {
      const bool stock = &with == &stock_;
      const std::string name = stock ? "opencv" : "simd_orb";
      with.name = "extractor " + name;
      with.extractor = makeFeatureExtractor(pipeline("", SearchMode::kFull, name).extractor);
      for (const SearchMode search : {SearchMode::kFull, SearchMode::kGuided}) {
        const bool guided = search == SearchMode::kGuided;
        if (stock && guided) continue;
        for (const std::string& method : options.methods) {
          filters_.push_back({method + (stock ? "" : " on " + with.name) + (guided ? ", guided" : ""),
                              with,
                              MatchFilter(pipeline(method, search, name)),
                              {}});
        }
      }
    }
  }

  Records run(const DatasetPair& pair) {
    records_.clear();
    const cv::Mat reference = dataset_.image(pair.reference), current = dataset_.image(pair.current);
    setCamera(current.size());
    for (FilterContender& contender : filters_) contender.filter.setCamera(camera_);
    const PairTruth truth(dataset_, pair, camera_);
    truth_ = &truth;
    for (ExtractorContender& contender : extractors_) {
      contender.extractor->extract(reference, contender.reference.features);
    }
    for (int repeat = 0; repeat < options_.repeat; ++repeat) {
      extract(current);
      match();
      filterByMotion();
      estimateBaseline();
      filterOurs();
      matchOurs();
    }
    return records_;
  }

  /// Frames first..first+count-1 one after the other, as a node gets them: OpenCV's chain with its first estimator, and
  /// each method on simd_orb.
  Records runFrames(int first, int count) {
    records_.clear();
    std::vector<cv::Mat> images;
    for (int i = first; i < first + count; ++i) images.push_back(dataset_.image(i));
    setCamera(images.front().size());
    const std::string baseline = chainName(baselineEstimators(camera_.calibrated()).front());
    // The first frame has nothing to be compared with, the second no motion before it.
    const auto run = [&](const std::string& what, const std::string& compared, const auto& process) {
      for (size_t i = 0; i < images.size(); ++i) {
        int inliers = 0;
        const double ms = time([&] { inliers = process(images[i]); });
        if (i >= 2) addRecord(kFrames, what, compared, ms, inliers, nullptr);
      }
    };
    for (int repeat = 0; repeat < options_.repeat; ++repeat) {
      Features before;
      cv::Mat descriptors;
      run(baseline, "", [&](const cv::Mat& image) { return baselineInliers(image, before, descriptors); });
      for (const std::string& method : options_.methods) {
        for (const SearchMode search : {SearchMode::kGuided, SearchMode::kFull}) {
          MatchFilter filter(pipeline(method, search, "simd_orb"));
          filter.setCamera(camera_);
          run(method + (search == SearchMode::kFull ? ", full search" : ""), baseline,
              [&](const cv::Mat& image) { return filter.process(image).inliers; });
        }
      }
    }
    return records_;
  }

 private:
  MatchFilterOptions pipeline(const std::string& method, SearchMode search, const std::string& extractor) const {
    MatchFilterOptions result;
    result.method = method;
    if (extractor == "opencv") result.extractor = MatchFilterOptions::paper().extractor;  // the pyramid of the baseline
    result.extractor.features = options_.features;
    result.extractor.fast_threshold = fastThreshold(options_.features);
    result.extractor.threads = result.matcher_threads = options_.threads;
    result.robust.model = options_.model;
    result.search = search;
    return result;
  }

  /// cv::ORB with the pyramid of our extractor.
  FeatureExtractorOptions samePyramid() const {
    FeatureExtractorOptions result = pipeline("", SearchMode::kFull, "simd_orb").extractor;
    result.extractor = "opencv";
    return result;
  }

  void setCamera(cv::Size size) {
    if (dataset_.intrinsics() && camera_.imageSize() != size) camera_ = Camera(*dataset_.intrinsics(), size);
  }

  /// Milliseconds of the work.
  template <typename Work>
  double time(const Work& work) const {
    const clockid_t clock = options_.threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
    const double start = secondsOf(clock);
    work();
    return 1e3 * (secondsOf(clock) - start);
  }

  /// `baseline`: what the same stage is compared with; empty: nothing.
  void addRecord(const std::string& stage, const std::string& what, const std::string& baseline, double ms, int kept,
                 const json& correct) {
    json& record = records_.emplace_back(json{
        {"stage", stage}, {"what", what}, {"ms", ms}, {"kept", kept}, {"correct", correct}, {"baseline", nullptr}});
    if (!baseline.empty()) record["baseline"] = baseline;
    record.update({{"features", options_.features}, {"threads", options_.threads}});
  }
  /// Counts the matches that are chosen by index; their features are those of the extractor.
  template <typename Chosen>
  void addRecord(const std::string& stage, const std::string& what, const std::string& baseline, double ms,
                 const ExtractorContender& extractor, const std::vector<Match>& matches, const Chosen& chosen) {
    int kept = 0, correct = 0;
    for (size_t i = 0; i < matches.size(); ++i) {
      if (!chosen(i)) continue;
      ++kept;
      correct += isCorrect(extractor.reference.features.keypoints[matches[i].reference].pt,
                           extractor.current.features.keypoints[matches[i].current].pt);
    }
    const bool known = truth_->hasEpipolar() || truth_->hasTransfer();
    addRecord(stage, what, baseline, ms, kept, known ? json(correct) : json());
  }
  bool isCorrect(const cv::Point2f& reference, const cv::Point2f& current) const {
    if (truth_->hasEpipolar()) return truth_->epipolarDistance(reference, current) < kCorrectWithin;
    const std::optional<double> distance = truth_->transferDistance(reference, current);
    return distance && *distance < kCorrectWithin;
  }

  void extract(const cv::Mat& image) {
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    baseline_extract_ms_ =
        time([&] { baseline_extractor_->detectAndCompute(image, cv::noArray(), keypoints, descriptors); });
    addRecord("extract", kBaselineExtractor, "", baseline_extract_ms_, static_cast<int>(keypoints.size()), nullptr);
    Features features;
    const double ms = time([&] { same_pyramid_->extract(image, features); });
    addRecord("extract", "extractor opencv, pyramid of simd_orb", kBaselineExtractor, ms, features.size(), nullptr);
    for (ExtractorContender& contender : extractors_) {
      contender.ms = time([&] { contender.extractor->extract(image, contender.current.features); });
      addRecord("extract", contender.name, kBaselineExtractor, contender.ms, contender.current.features.size(),
                nullptr);
    }
  }

  /// Times what finds matches. Returns milliseconds.
  template <typename Work>
  double match(const std::string& what, const std::string& baseline, const ExtractorContender& extractor,
               const std::vector<Match>& found, const Work& work) {
    const double ms = time(work);
    addRecord(kMatch, what, baseline, ms, extractor, found, [](size_t) { return true; });
    return ms;
  }

  void match() {
    const Features& reference = stock_.reference.features;
    Features& current = stock_.current.features;
    const cv::Mat queries = reference.descriptors.asMat(), train = current.descriptors.asMat();
    baseline_match_ms_ =
        match(kBaselineMatcher, "", stock_, matches_, [&] { matches_ = baselineMatches(queries, train); });
    for (MatcherContender& contender : matchers_) {
      current.descriptors.pack(contender.level);
      match(contender.name, kBaselineMatcher, stock_, ours_,
            [&] { contender.matcher.match(reference.descriptors, current.descriptors, ours_); });
    }
    current.descriptors.pack();
  }

  /// The raw matches of our own extractor, by full and by guided search.
  void matchOurs() {
    const ExtractorContender& extractor = extractors_.back();
    const Features &reference = extractor.reference.features, &current = extractor.current.features;
    const std::string name = toString(detectSimdLevel()) + " on " + extractor.name;
    match(name, kBaselineMatcher, extractor, ours_,
          [&] { matchers_.front().matcher.match(reference.descriptors, current.descriptors, ours_); });
    match(name + ", guided", kBaselineMatcher, extractor, ours_,
          [&] { guided_search_.match(reference, current, ours_); });
  }

  void filterByMotion() {
    const Features &reference = stock_.reference.features, &current = stock_.current.features;
    const auto run = [&](const char* stage, const char* what, const char* baseline, const auto& work) {
      const double ms = time(work);
      addRecord(stage, what, baseline, ms, stock_, matches_, [this](size_t i) { return statistics_.accepted[i] != 0; });
      return ms;
    };
    run(kGmsAll, kBaselineGms, "",
        [&] { denseMotionStatistics(gms_all_options_, reference, current, matches_, statistics_); });
    run(kGmsAll, "sparse", kBaselineGms, [&] { gms_all_.compute(reference, current, matches_, statistics_); });
    run(kGms, "sparse", kBaselineGms, [&] { gms_.compute(reference, current, matches_, statistics_); });
    baseline_gms_ms_ =
        run(kGms, kBaselineGms, "", [&] { denseMotionStatistics({}, reference, current, matches_, statistics_); });
  }

  void estimateBaseline() {
    for (const BaselineEstimator& estimator : baselineEstimators(camera_.calibrated())) {
      std::vector<Match> survivors = acceptedOf(matches_, statistics_);
      std::vector<uint8_t> inlier;
      const double ms = time([&] {
        inlier = estimate(estimator, stock_.reference.features.keypoints, stock_.current.features.keypoints, camera_,
                          survivors);
      });
      inlier.resize(survivors.size(), 0);
      const auto addStage = [&](const char* stage, const std::string& what, double sum) {
        addRecord(stage, what, "", sum, stock_, survivors, [&](size_t i) { return inlier[i] != 0; });
      };
      const double filter_ms = baseline_match_ms_ + baseline_gms_ms_ + ms;
      addStage(kEstimate, estimator.name, ms);
      addStage(kFilter, chainName(estimator), filter_ms);
      addStage(kFrame, chainName(estimator), baseline_extract_ms_ + filter_ms);
    }
  }

  void filterOurs() {
    const BaselineEstimator baseline = baselineEstimators(camera_.calibrated()).front();
    const std::string chain = chainName(baseline);
    for (FilterContender& contender : filters_) {
      const ExtractorContender& extractor = contender.extractor;
      const double ms =
          time([&] { contender.filter.filter(extractor.reference, extractor.current, contender.result); });
      const auto addStage = [&](const char* stage, const std::string& compared, double sum) {
        addRecord(stage, contender.name, compared, sum, extractor, contender.result.matches,
                  [&](size_t row) { return contender.result.isInlier(row); });
      };
      addStage(kFilter, chain, ms);
      addStage(kFrame, chain, extractor.ms + ms);
      // The survivors of the baseline; by the wall clock, because it is measured inside.
      if (&extractor == &stock_) addStage(kEstimate, baseline.name, contender.result.times.ransac * 1e3);
    }
  }

  /// OpenCV's chain on the image after `before`, whose place it takes. Returns the number of inliers.
  int baselineInliers(const cv::Mat& image, Features& before, cv::Mat& descriptors_before) {
    Features now;
    cv::Mat descriptors;
    baseline_extractor_->detectAndCompute(image, cv::noArray(), now.keypoints, descriptors);
    now.image_size = image.size();
    std::vector<uint8_t> inlier;
    if (!descriptors_before.empty() && !descriptors.empty()) {
      const std::vector<Match> matches = baselineMatches(descriptors_before, descriptors);
      denseMotionStatistics({}, before, now, matches, statistics_);
      std::vector<Match> survivors = acceptedOf(matches, statistics_);
      inlier = estimate(baselineEstimators(camera_.calibrated()).front(), before.keypoints, now.keypoints, camera_,
                        survivors);
    }
    std::swap(before, now);
    descriptors_before = descriptors;
    return static_cast<int>(inlier.size() - static_cast<size_t>(std::count(inlier.begin(), inlier.end(), 0)));
  }

  const Dataset& dataset_;
  const BenchmarkOptions options_;
  const cv::Ptr<cv::ORB> baseline_extractor_;
  const std::unique_ptr<FeatureExtractor> same_pyramid_;
  std::vector<ExtractorContender> extractors_{2};
  ExtractorContender& stock_ = extractors_[0];  ///< its features are the baseline's
  std::vector<MatcherContender> matchers_;
  std::deque<FilterContender> filters_;
  GuidedSearch guided_search_;
  const MotionStatisticsOptions gms_all_options_ = [] {
    MotionStatisticsOptions options;
    options.rotation = options.scale = true;
    return options;
  }();
  MotionStatisticsFilter gms_, gms_all_{gms_all_options_};

  Records records_;
  // The current pair.
  Camera camera_;
  const PairTruth* truth_ = nullptr;
  std::vector<Match> matches_, ours_;  ///< the baseline's, and those of a matcher of ours
  MotionStatistics statistics_;
  double baseline_extract_ms_ = 0, baseline_match_ms_ = 0, baseline_gms_ms_ = 0;
};

}  // namespace

Series benchmarkSeries(const Dataset& dataset, const std::vector<DatasetPair>& pairs, const BenchmarkOptions& options) {
  return {"", pairs.size(), [&dataset, &pairs, options] {
            cv::setNumThreads(options.threads);
            const auto suite = std::make_shared<Suite>(dataset, options);
            return [&dataset, &pairs, options, suite](size_t pair) {
              Records records = suite->run(pairs[pair]);
              const int first = pairs.front().reference;
              const int count = std::min(options.frames, static_cast<int>(dataset.frames().size()) - first);
              if (pair + 1 < pairs.size() || count < 3) return records;
              const Records of_frames = suite->runFrames(first, count);
              records.insert(records.end(), of_frames.begin(), of_frames.end());
              return records;
            };
          }};
}

}  // namespace gms_ransac
