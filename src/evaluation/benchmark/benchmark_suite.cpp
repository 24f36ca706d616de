#include "benchmark/benchmark_suite.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <set>

#include "benchmark/dense_motion_statistics.h"
#include "benchmark/opencv_baseline.h"
#include "gms/guided_search.h"
#include "gms_ransac/match_filter.h"
#include "run/pair_truth.h"

namespace gms_ransac {

namespace {

const char kMatch[] = "match", kGms[] = "GMS", kGmsAll[] = "GMS, rotation + scale", kRobust[] = "estimate",
           kFilter[] = "match + GMS + estimate", kFrame[] = "whole frame";
const char kGuided[] = ", guided";
const char kBaselineMatcher[] = "cv::BFMatcher", kBaselineGms[] = "dense GMS", kBaselineExtractor[] = "cv::ORB";

/// Our matcher at one instruction set, with train descriptors packed for it.
struct MatcherContender {
  std::string name;
  SimdLevel level;
  HammingMatcher matcher;
};

struct ExtractorContender {
  std::string name;
  std::unique_ptr<FeatureExtractor> extractor;
  Frame reference, current;
  double ms = 0;  ///< last extraction of the current image
};

/// Our pipeline with one extractor and one method.
struct FilterContender {
  std::string name;
  const ExtractorContender& extractor;
  bool guided;
  MatchFilter filter;
  MatchResult result;
};

std::vector<Match> toMatches(const std::vector<cv::DMatch>& matches) {
  std::vector<Match> result;
  result.reserve(matches.size());
  for (const cv::DMatch& m : matches) {
    result.push_back({m.queryIdx, m.trainIdx, static_cast<uint16_t>(m.distance), 0});
  }
  return result;
}

std::string baselineName(const BaselineEstimator& estimator) { return "OpenCV with " + estimator.name; }

class Suite {
 public:
  Suite(const Dataset& dataset, const BenchmarkOptions& options)
      : dataset_(dataset),
        options_(options),
        clock_(options.threads),
        baseline_extractor_(makeBaselineExtractor(options.features)),
        guided_search_({false, options.threads}, {}) {
    for (SimdLevel level : {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kNeon, SimdLevel::kScalar}) {
      if (!simdLevelSupported(level)) continue;
      for (const bool mutual : {false, true}) {
        matchers_.push_back({toString(level) + (mutual ? ", mutual" : ""), level,
                             HammingMatcher(HammingMatcherOptions{mutual, options.threads, level})});
      }
    }
    for (const std::string name : {"opencv", "simd_orb"}) {
      extractors_.emplace_back();
      extractors_.back().name = "extractor " + name;
      extractors_.back().extractor = makeFeatureExtractor(options.pipeline("", SearchMode::kFull, name).extractor);
      addFilters(name, SearchMode::kFull);
      if (name != "opencv") addFilters(name, SearchMode::kGuided);
    }
  }

  void run(const DatasetPair& pair) {
    const cv::Mat reference = dataset_.image(pair.reference), current = dataset_.image(pair.current);
    if (dataset_.intrinsics() && camera_.imageSize() != current.size()) {
      camera_ = Camera(*dataset_.intrinsics(), current.size());
      for (FilterContender& contender : filters_) contender.filter.setCamera(camera_);
    }
    truth_ = std::make_unique<PairTruth>(dataset_, pair, camera_);
    for (ExtractorContender& contender : extractors_) {
      contender.extractor->extract(reference, contender.reference.features);
    }
    for (int repeat = 0; repeat < options_.repeat; ++repeat) {
      counting_ = repeat == 0;
      extract(current);
      match();
      filterByMotion();
      estimateBaseline();
      filterOurs();
      matchOurs();
    }
  }

  BenchmarkTable table;

 private:
  void addFilters(const std::string& extractor, SearchMode search) {
    const ExtractorContender& with = extractors_.back();
    const bool guided = search == SearchMode::kGuided;
    for (const std::string& method : options_.methods) {
      const MatchFilterOptions options = options_.pipeline(method, search, extractor);
      options.validate();
      const std::string name =
          method + (&with == &extractors_.front() ? "" : " on " + with.name) + (guided ? kGuided : "");
      filters_.push_back(FilterContender{name, with, guided, MatchFilter(options), {}});
    }
  }

  void extract(const cv::Mat& image) {
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    BenchmarkRow& baseline = table.row("extract", kBaselineExtractor);
    baseline_extract_ms_ = baseline.time(
        clock_, [&] { baseline_extractor_->detectAndCompute(image, cv::noArray(), keypoints, descriptors); });
    if (counting_) baseline.count(static_cast<int>(keypoints.size()));
    for (ExtractorContender& contender : extractors_) {
      BenchmarkRow& row = table.row("extract", contender.name, kBaselineExtractor);
      contender.ms = row.time(clock_, [&] { contender.extractor->extract(image, contender.current.features); });
      if (counting_) row.count(contender.current.features.size());
    }
  }

  void match() {
    const Features& reference = extractors_[0].reference.features;
    Features& current = extractors_[0].current.features;
    const cv::Mat queries = reference.descriptors.asMat(), train = current.descriptors.asMat();
    BenchmarkRow& baseline = table.row(kMatch, kBaselineMatcher);
    baseline_match_ms_ =
        baseline.time(clock_, [&] { cv::BFMatcher(cv::NORM_HAMMING).match(queries, train, baseline_matches_); });
    count(baseline, toMatches(baseline_matches_));
    for (MatcherContender& contender : matchers_) {
      current.descriptors.pack(contender.level);
      BenchmarkRow& row = table.row(kMatch, contender.name, kBaselineMatcher);
      row.time(clock_, [&] { contender.matcher.match(reference.descriptors, current.descriptors, matches_); });
      count(row, matches_);
    }
    current.descriptors.pack();
    matches_ = toMatches(baseline_matches_);
  }

  void filterByMotion() {
    const Features& reference = extractors_[0].reference.features;
    const Features& current = extractors_[0].current.features;
    const auto run = [&](BenchmarkRow& row, const auto& work) {
      const double ms = row.time(clock_, work);
      count(row, matches_, [this](size_t i) { return statistics_.accepted[i]; });
      return ms;
    };
    run(table.row(kGmsAll, kBaselineGms),
        [&] { denseMotionStatistics(gms_all_options_, reference, current, matches_, statistics_); });
    run(table.row(kGmsAll, "sparse", kBaselineGms),
        [&] { gms_all_.compute(reference, current, matches_, statistics_); });
    BenchmarkRow& dense = table.row(kGms, kBaselineGms);
    run(table.row(kGms, "sparse", kBaselineGms), [&] { gms_.compute(reference, current, matches_, statistics_); });
    baseline_gms_ms_ = run(dense, [&] { denseMotionStatistics({}, reference, current, matches_, statistics_); });
  }

  void estimateBaseline() {
    const std::vector<cv::KeyPoint>& reference = extractors_[0].reference.features.keypoints;
    const std::vector<cv::KeyPoint>& current = extractors_[0].current.features.keypoints;
    for (const BaselineEstimator& estimator : baselineEstimators(camera_.calibrated())) {
      std::vector<cv::DMatch> survivors;
      for (size_t i = 0; i < baseline_matches_.size(); ++i) {
        if (statistics_.accepted[i]) survivors.push_back(baseline_matches_[i]);
      }
      std::vector<uint8_t> inlier;
      BenchmarkRow* rows[] = {&table.row(kRobust, estimator.name), &table.row(kFilter, baselineName(estimator)),
                              &table.row(kFrame, baselineName(estimator))};
      const double ms =
          rows[0]->time(clock_, [&] { inlier = estimate(estimator, reference, current, camera_, survivors); });
      const double filter_ms = baseline_match_ms_ + baseline_gms_ms_ + ms;
      rows[1]->ms.push_back(filter_ms);
      rows[2]->ms.push_back(baseline_extract_ms_ + filter_ms);
      inlier.resize(survivors.size(), 0);
      for (BenchmarkRow* row : rows) count(*row, toMatches(survivors), [&](size_t i) { return inlier[i]; });
    }
  }

  void filterOurs() {
    const BaselineEstimator baseline = baselineEstimators(camera_.calibrated()).front();
    for (FilterContender& contender : filters_) {
      const ExtractorContender& extractor = contender.extractor;
      contender.filter.reset();  // the estimator has seen this pair before and must not profit from it
      std::vector<BenchmarkRow*> rows = {&table.row(kFilter, contender.name, baselineName(baseline)),
                                         &table.row(kFrame, contender.name, baselineName(baseline))};
      const double ms = rows[0]->time(
          clock_, [&] { contender.filter.filter(extractor.reference, extractor.current, contender.result); });
      rows[1]->ms.push_back(extractor.ms + ms);
      if (&extractor == &extractors_[0]) {  // the survivors of the baseline
        rows.push_back(&table.row(kRobust, contender.name, baseline.name));
        rows[2]->ms.push_back(contender.result.times.ransac * 1e3);  // by the wall clock: measured inside
      }
      for (BenchmarkRow* row : rows) count(*row, contender, MatchStage::kInlier);
    }
  }

  /// The raw matches of our own extractor, by full and by guided search.
  void matchOurs() {
    std::set<bool> seen;
    for (const FilterContender& contender : filters_) {
      if (&contender.extractor == &extractors_[0] || !seen.insert(contender.guided).second) continue;
      const Features &reference = contender.extractor.reference.features,
                     &current = contender.extractor.current.features;
      const std::string name =
          toString(detectSimdLevel()) + " on " + contender.extractor.name + (contender.guided ? kGuided : "");
      BenchmarkRow& row = table.row(kMatch, name, kBaselineMatcher);
      row.time(clock_, [&] {
        contender.guided ? guided_search_.match(reference, current, matches_)
                         : matchers_.front().matcher.match(reference.descriptors, current.descriptors, matches_);
      });
      count(row, contender, MatchStage::kRaw);
    }
  }

  /// Counts matches of the first repetition that are chosen by index; those of the first extractor without `of`.
  void count(
      BenchmarkRow& row, const std::vector<Match>& matches,
      const std::function<bool(size_t)>& chosen = [](size_t) { return true; },
      const ExtractorContender* of = nullptr) const {
    if (!counting_) return;
    const ExtractorContender& extractor = of ? *of : extractors_[0];
    const bool with_truth = truth_->hasEpipolar() || truth_->hasTransfer();
    int kept = 0, correct = 0;
    for (size_t i = 0; i < matches.size(); ++i) {
      if (!chosen(i)) continue;
      ++kept;
      correct += with_truth && isCorrect(extractor.reference.features.keypoints[matches[i].reference].pt,
                                         extractor.current.features.keypoints[matches[i].current].pt);
    }
    row.count(kept);
    if (with_truth) row.countCorrect(correct);
  }
  /// Those of the contender that reached `stage`.
  void count(BenchmarkRow& row, const FilterContender& contender, MatchStage stage) const {
    const MatchResult& result = contender.result;
    count(
        row, result.matches, [&](size_t i) { return result.stage[i] >= stage; }, &contender.extractor);
  }
  bool isCorrect(const cv::Point2f& reference, const cv::Point2f& current) const {
    if (truth_->hasEpipolar()) return truth_->epipolarDistance(reference, current) < kCorrectWithin;
    const std::optional<double> distance = truth_->transferDistance(reference, current);
    return distance && *distance < kCorrectWithin;
  }

  const Dataset& dataset_;
  const BenchmarkOptions options_;
  const StageClock clock_;
  const cv::Ptr<cv::ORB> baseline_extractor_;
  std::deque<ExtractorContender> extractors_;  ///< opencv, simd_orb; the first one's features are the baseline's
  std::vector<MatcherContender> matchers_;
  std::deque<FilterContender> filters_;
  GuidedSearch guided_search_;
  const MotionStatisticsOptions gms_all_options_ = [] {
    MotionStatisticsOptions options;
    options.rotation = options.scale = true;
    return options;
  }();
  MotionStatisticsFilter gms_, gms_all_{gms_all_options_};

  // The current pair.
  Camera camera_;
  std::unique_ptr<PairTruth> truth_;
  bool counting_ = false;  ///< the first repetition: matches are counted, besides the times
  std::vector<cv::DMatch> baseline_matches_;
  std::vector<Match> matches_;
  MotionStatistics statistics_;
  double baseline_extract_ms_ = 0, baseline_match_ms_ = 0, baseline_gms_ms_ = 0;
};

}  // namespace

MatchFilterOptions BenchmarkOptions::pipeline(const std::string& method, SearchMode search,
                                              const std::string& extractor) const {
  MatchFilterOptions result;
  result.method = method;
  result.extractor.extractor = extractor;
  result.extractor.features = features;
  result.extractor.fast_threshold = fastThreshold(features);
  result.extractor.threads = result.matcher_threads = threads;
  result.robust.model = model;
  result.search = search;
  return result;
}

BenchmarkTable runBenchmark(const Dataset& dataset, const std::vector<DatasetPair>& pairs,
                            const BenchmarkOptions& options, const std::function<void()>& pair_done) {
  cv::setNumThreads(options.threads);
  Suite suite(dataset, options);
  for (const DatasetPair& pair : pairs) {
    suite.run(pair);
    pair_done();
  }
  const int first = pairs.front().reference;
  const int count = std::min(options.frames, static_cast<int>(dataset.frames().size()) - first);
  if (count > 2) runFrames(dataset, first, count, options, suite.table);
  return suite.table;
}

}  // namespace gms_ransac
