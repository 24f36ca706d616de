#include "benchmark/benchmark_suite.h"

#include <algorithm>
#include <memory>
#include <set>

#include "benchmark/dense_motion_statistics.h"
#include "benchmark/frame_benchmark.h"
#include "benchmark/opencv_baseline.h"
#include "gms/guided_search.h"
#include "gms_ransac/match_filter.h"
#include "run/pair_truth.h"

namespace gms_ransac {

namespace {

const char kExtract[] = "extract", kMatch[] = "match", kGms[] = "GMS", kGmsAll[] = "GMS, rotation + scale",
           kRobust[] = "estimate", kFilter[] = "match + GMS + estimate", kFrame[] = "whole frame";
const char kGuided[] = ", guided";
const char kBaselineMatcher[] = "cv::BFMatcher", kBaselineGms[] = "dense GMS", kBaselineExtractor[] = "cv::ORB";

/// Our matcher at one instruction set, with train descriptors packed for it.
struct MatcherContender {
  std::string name;
  SimdLevel level;
  HammingMatcher matcher;
};

/// Our pipeline with one extractor and one method.
struct FilterContender {
  std::string name;
  int extractor;  ///< index into Suite::extractors_
  SearchMode search;
  MatchFilter filter;
  MatchResult result;
};

struct ExtractorContender {
  std::string name;
  std::unique_ptr<FeatureExtractor> extractor;
  Frame reference, current;
  double ms = 0;  ///< last extraction of the current image
};

int referenceOf(const Match& match) { return match.reference; }
int referenceOf(const cv::DMatch& match) { return match.queryIdx; }
int currentOf(const Match& match) { return match.current; }
int currentOf(const cv::DMatch& match) { return match.trainIdx; }

class Suite {
 public:
  Suite(const Dataset& dataset, const BenchmarkOptions& options);
  void run(const DatasetPair& pair);
  BenchmarkTable& table() { return table_; }

 private:
  void setCamera(cv::Size image_size);
  void addFilters(int extractor, const FeatureExtractorOptions& extractor_options, SearchMode search);

  // The stages; `counting`: matches are counted, besides the times.
  void extract(const cv::Mat& image, bool counting);
  void match(bool counting);
  void filterByMotion(bool counting);
  void estimateBaseline(bool counting);
  void filterOurs(bool counting);
  void matchOurs(bool counting);

  /// Counts the matches of an extractor's features that are chosen by index.
  template <typename Matches, typename Chosen>
  void count(BenchmarkRow& row, const Matches& matches, const ExtractorContender& extractor,
             const Chosen& chosen) const;
  void count(BenchmarkRow& row, const std::vector<cv::DMatch>& matches, const std::vector<uint8_t>* kept) const;
  /// Counts the contender's matches that reached `stage`.
  void count(BenchmarkRow& row, const FilterContender& contender, MatchStage stage) const;
  bool isCorrect(const cv::Point2f& reference, const cv::Point2f& current) const;
  bool hasTruth() const { return truth_->hasEpipolar() || truth_->hasTransfer(); }

  const Dataset& dataset_;
  BenchmarkOptions options_;
  StageClock clock_;
  BenchmarkTable table_;
  Camera camera_;
  std::unique_ptr<PairTruth> truth_;

  cv::Ptr<cv::ORB> baseline_extractor_;
  std::vector<ExtractorContender> extractors_;  ///< opencv, simd_orb; the first one's features are the baseline's
  std::vector<MatcherContender> matchers_;
  GuidedSearch guided_search_;
  std::vector<std::unique_ptr<FilterContender>> filters_;
  MotionStatisticsOptions gms_all_options_;
  MotionStatisticsFilter gms_, gms_all_;

  /// Current pair.
  std::vector<cv::DMatch> baseline_matches_, baseline_survivors_;
  std::vector<Match> matches_;
  MotionStatistics statistics_;
  double baseline_extract_ms_ = 0, baseline_match_ms_ = 0, baseline_gms_ms_ = 0;
};

MotionStatisticsOptions withRotationAndScale() {
  MotionStatisticsOptions options;
  options.rotation = options.scale = true;
  return options;
}

Suite::Suite(const Dataset& dataset, const BenchmarkOptions& options)
    : dataset_(dataset),
      options_(options),
      clock_(options.threads),
      baseline_extractor_(makeBaselineExtractor(options.features)),
      guided_search_({false, options.threads}, {}),
      gms_all_options_(withRotationAndScale()),
      gms_all_(gms_all_options_) {
  for (SimdLevel level : {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kNeon, SimdLevel::kScalar}) {
    if (!simdLevelSupported(level)) continue;
    const HammingMatcherOptions nearest{false, options.threads, level}, mutual{true, options.threads, level};
    matchers_.push_back({toString(level), level, HammingMatcher(nearest)});
    matchers_.push_back({toString(level) + ", mutual", level, HammingMatcher(mutual)});
  }
  for (const char* name : {"opencv", "simd_orb"}) {
    FeatureExtractorOptions extractor;
    extractor.extractor = name;
    extractor.features = options.features;
    extractor.fast_threshold = fastThreshold(options.features);
    extractor.threads = options.threads;
    extractors_.push_back({std::string("extractor ") + name, makeFeatureExtractor(extractor), {}, {}, 0});
    const int index = static_cast<int>(extractors_.size()) - 1;
    addFilters(index, extractor, SearchMode::kFull);
    if (index > 0) addFilters(index, extractor, SearchMode::kGuided);
  }
}

void Suite::addFilters(int extractor, const FeatureExtractorOptions& extractor_options, SearchMode search) {
  for (const std::string& method : options_.methods) {
    MatchFilterOptions options;
    options.method = method;
    options.extractor = extractor_options;
    options.robust.model = options_.model;
    options.search = search;
    options.matcher_threads = options_.threads;
    options.validate();
    const std::string name = method + (extractor == 0 ? "" : " on " + extractors_[extractor].name) +
                             (search == SearchMode::kGuided ? kGuided : "");
    filters_.emplace_back(new FilterContender{name, extractor, search, MatchFilter(options), {}});
  }
}

void Suite::setCamera(cv::Size image_size) {
  if (!dataset_.intrinsics() || camera_.imageSize() == image_size) return;
  camera_ = Camera(*dataset_.intrinsics(), image_size);
  for (auto& contender : filters_) contender->filter.setCamera(camera_);
}

void Suite::run(const DatasetPair& pair) {
  const cv::Mat reference = dataset_.image(pair.reference), current = dataset_.image(pair.current);
  setCamera(current.size());
  truth_ = std::make_unique<PairTruth>(dataset_, pair, camera_);
  for (ExtractorContender& contender : extractors_) {
    contender.extractor->extract(reference, contender.reference.features);
  }
  for (int repeat = 0; repeat < options_.repeat; ++repeat) {
    const bool counting = repeat == 0;
    extract(current, counting);
    match(counting);
    filterByMotion(counting);
    estimateBaseline(counting);
    filterOurs(counting);
  }
}

void Suite::extract(const cv::Mat& image, bool counting) {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  BenchmarkRow& baseline = table_.row(kExtract, kBaselineExtractor);
  baseline_extract_ms_ = baseline.time(
      clock_, [&] { baseline_extractor_->detectAndCompute(image, cv::noArray(), keypoints, descriptors); });
  if (counting) baseline.count(static_cast<int>(keypoints.size()));
  for (ExtractorContender& contender : extractors_) {
    BenchmarkRow& row = table_.row(kExtract, contender.name, kBaselineExtractor);
    contender.ms = row.time(clock_, [&] { contender.extractor->extract(image, contender.current.features); });
    if (counting) row.count(contender.current.features.size());
  }
}

void Suite::match(bool counting) {
  const Features& reference = extractors_[0].reference.features;
  Features& current = extractors_[0].current.features;
  const cv::Mat queries = reference.descriptors.asMat(), train = current.descriptors.asMat();
  BenchmarkRow& baseline = table_.row(kMatch, kBaselineMatcher);
  baseline_match_ms_ =
      baseline.time(clock_, [&] { cv::BFMatcher(cv::NORM_HAMMING).match(queries, train, baseline_matches_); });
  if (counting) count(baseline, baseline_matches_, nullptr);

  for (MatcherContender& contender : matchers_) {
    current.descriptors.pack(contender.level);
    BenchmarkRow& row = table_.row(kMatch, contender.name, kBaselineMatcher);
    row.time(clock_, [&] { contender.matcher.match(reference.descriptors, current.descriptors, matches_); });
    if (!counting) continue;
    std::vector<cv::DMatch> matches;
    for (const Match& m : matches_) matches.emplace_back(m.reference, m.current, static_cast<float>(m.distance));
    count(row, matches, nullptr);
  }
  current.descriptors.pack();
  matches_.clear();
  for (const cv::DMatch& m : baseline_matches_) {
    matches_.push_back({m.queryIdx, m.trainIdx, static_cast<uint16_t>(m.distance), 0});
  }
}

void Suite::filterByMotion(bool counting) {
  const Features& reference = extractors_[0].reference.features;
  const Features& current = extractors_[0].current.features;
  const auto run = [&](BenchmarkRow& row, const auto& work) {
    const double ms = row.time(clock_, work);
    if (counting) count(row, baseline_matches_, &statistics_.accepted);
    return ms;
  };
  run(table_.row(kGmsAll, kBaselineGms),
      [&] { denseMotionStatistics(gms_all_options_, reference, current, matches_, statistics_); });
  run(table_.row(kGmsAll, "sparse", kBaselineGms),
      [&] { gms_all_.compute(reference, current, matches_, statistics_); });
  BenchmarkRow& dense = table_.row(kGms, kBaselineGms);
  run(table_.row(kGms, "sparse", kBaselineGms), [&] { gms_.compute(reference, current, matches_, statistics_); });
  baseline_gms_ms_ = run(dense, [&] { denseMotionStatistics({}, reference, current, matches_, statistics_); });
  baseline_survivors_.clear();
  for (size_t i = 0; i < baseline_matches_.size(); ++i) {
    if (statistics_.accepted[i]) baseline_survivors_.push_back(baseline_matches_[i]);
  }
}

std::string baselineName(const BaselineEstimator& estimator) { return "OpenCV with " + estimator.name; }

void Suite::estimateBaseline(bool counting) {
  const std::vector<cv::KeyPoint>& reference = extractors_[0].reference.features.keypoints;
  const std::vector<cv::KeyPoint>& current = extractors_[0].current.features.keypoints;
  for (const BaselineEstimator& estimator : baselineEstimators(camera_.calibrated())) {
    std::vector<cv::DMatch> survivors = baseline_survivors_;
    std::vector<uint8_t> inlier;
    BenchmarkRow* rows[] = {&table_.row(kRobust, estimator.name), &table_.row(kFilter, baselineName(estimator)),
                            &table_.row(kFrame, baselineName(estimator))};
    const double ms =
        rows[0]->time(clock_, [&] { inlier = estimate(estimator, reference, current, camera_, survivors); });
    const double filter_ms = baseline_match_ms_ + baseline_gms_ms_ + ms;
    rows[1]->ms.push_back(filter_ms);
    rows[2]->ms.push_back(baseline_extract_ms_ + filter_ms);
    if (!counting) continue;
    inlier.resize(survivors.size(), 0);
    for (BenchmarkRow* row : rows) count(*row, survivors, &inlier);
  }
}

void Suite::filterOurs(bool counting) {
  const BaselineEstimator baseline = baselineEstimators(camera_.calibrated()).front();
  for (auto& contender : filters_) {
    const ExtractorContender& extractor = extractors_[contender->extractor];
    contender->filter.reset();  // the estimator has seen this pair before and must not profit from it
    std::vector<BenchmarkRow*> rows = {&table_.row(kFilter, contender->name, baselineName(baseline)),
                                       &table_.row(kFrame, contender->name, baselineName(baseline))};
    const double ms = rows[0]->time(
        clock_, [&] { contender->filter.filter(extractor.reference, extractor.current, contender->result); });
    rows[1]->ms.push_back(extractor.ms + ms);
    if (contender->extractor == 0) {  // the survivors of the baseline
      rows.push_back(&table_.row(kRobust, contender->name, baseline.name));
      rows[2]->ms.push_back(contender->result.times.ransac * 1e3);  // by the wall clock: measured inside
    }
    if (counting) {
      for (BenchmarkRow* row : rows) count(*row, *contender, MatchStage::kInlier);
    }
  }
  matchOurs(counting);
}

/// The raw matches of our own extractor, by full and by guided search.
void Suite::matchOurs(bool counting) {
  std::set<SearchMode> seen;
  for (const auto& contender : filters_) {
    if (contender->extractor == 0 || !seen.insert(contender->search).second) continue;
    const ExtractorContender& extractor = extractors_[contender->extractor];
    const Features &reference = extractor.reference.features, &current = extractor.current.features;
    const bool guided = contender->search == SearchMode::kGuided;
    const std::string name = toString(detectSimdLevel()) + " on " + extractor.name + (guided ? kGuided : "");
    BenchmarkRow& row = table_.row(kMatch, name, kBaselineMatcher);
    row.time(clock_, [&] {
      guided ? guided_search_.match(reference, current, matches_)
             : matchers_.front().matcher.match(reference.descriptors, current.descriptors, matches_);
    });
    if (counting) count(row, *contender, MatchStage::kRaw);
  }
}

bool Suite::isCorrect(const cv::Point2f& reference, const cv::Point2f& current) const {
  if (truth_->hasEpipolar()) return truth_->epipolarDistance(reference, current) < kCorrectWithin;
  const std::optional<double> distance = truth_->transferDistance(reference, current);
  return distance && *distance < kCorrectWithin;
}

template <typename Matches, typename Chosen>
void Suite::count(BenchmarkRow& row, const Matches& matches, const ExtractorContender& extractor,
                  const Chosen& chosen) const {
  int kept = 0, correct = 0;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!chosen(i)) continue;
    ++kept;
    correct += hasTruth() && isCorrect(extractor.reference.features.keypoints[referenceOf(matches[i])].pt,
                                       extractor.current.features.keypoints[currentOf(matches[i])].pt);
  }
  row.count(kept);
  if (hasTruth()) row.countCorrect(correct);
}

void Suite::count(BenchmarkRow& row, const std::vector<cv::DMatch>& matches, const std::vector<uint8_t>* kept) const {
  count(row, matches, extractors_[0], [&](size_t i) { return !kept || (*kept)[i]; });
}

void Suite::count(BenchmarkRow& row, const FilterContender& contender, MatchStage stage) const {
  const MatchResult& result = contender.result;
  count(row, result.matches, extractors_[contender.extractor], [&](size_t i) { return result.stage[i] >= stage; });
}

}  // namespace

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
  if (count > 2) runFrames(dataset, first, count, options, suite.table());
  return suite.table();
}

}  // namespace gms_ransac
