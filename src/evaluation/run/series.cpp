#include "run/series.h"

#include <algorithm>
#include <future>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "gms_ransac/match_filter.h"
#include "match_filter_hooks.h"
#include "run/record.h"

namespace gms_ransac {

namespace {

using nlohmann::json;

constexpr int kRounds = 3;  ///< of stages that are timed; the first one pays for memory and caches
/// That give the first pair its past where a series does not begin with it, times the gap.
constexpr size_t kPairsBefore = 4;
constexpr size_t kPairsOfSequence = kSequenceImages - 1;
constexpr double kSweepNoise = 0.35;  ///< standard deviation of each coordinate, pixels: 0.5 between the two images

/// Runs pipelines over pairs of a set.
class Experiment {
 public:
  Experiment(const MeasuredSet& set, const Pipelines& pipelines, int gap, bool correspondences)
      : set_(set), gap_(gap), correspondences_(correspondences), first_seed_(pipelines.front().robust.seed) {
    for (const MatchFilterOptions& options : pipelines) filters_.emplace_back(options);
  }

  /// Reads the images of the `next` pair, if there is one, on other threads.
  Records run(const DatasetPair& pair, const DatasetPair* next);
  Records time(const DatasetPair& pair, int seeds);

 private:
  void readAhead(const DatasetPair& pair);
  /// `fixed`: to the camera, as the stream has shown it.
  const Frame& frame(int index, int rounds, const LearnedMask& fixed = LearnedMask());
  /// Extracts what is missing, drops what is not needed any more, and sets the camera.
  PairTruth prepare(const DatasetPair& pair, int rounds, const LearnedMask& fixed = LearnedMask());
  json record(const DatasetPair& pair, const PairTruth& truth, const MatchFilterOptions& options,
              const MatchResult& result) const;

  const MeasuredSet& set_;
  const int gap_;
  const bool correspondences_;
  const uint64_t first_seed_;  ///< that a record's `repeat` counts from
  std::vector<MatchFilter> filters_;
  std::map<int, std::future<cv::Mat>> ahead_;  ///< images that are being read
  std::map<int, Frame> frames_;                ///< extracted and still needed
  std::map<int, std::vector<Past>> pasts_;     ///< of each filter, by the current image of a pair
  Camera camera_;
  MatchResult result_;
};

void Experiment::readAhead(const DatasetPair& pair) {
  for (const int index : {pair.reference, pair.current}) {
    if (frames_.count(index) > 0 || ahead_.count(index) > 0) continue;
    ahead_[index] = std::async(std::launch::async, [this, index] { return set_.dataset.image(index); });
  }
}

const Frame& Experiment::frame(int index, int rounds, const LearnedMask& fixed) {
  const auto [place, is_new] = frames_.try_emplace(index);
  Frame& frame = place->second;
  if (!is_new) return frame;
  auto ahead = ahead_.extract(index);
  const cv::Mat image = ahead ? ahead.mapped().get() : set_.dataset.image(index);
  double fastest = std::numeric_limits<double>::infinity();
  for (int round = 0; round < rounds; ++round) {
    filters_.front().extract(image, frame, fixed.forExtraction(cv::Mat(), image.size()), set_.dataset.stamp(index));
    fastest = std::min(fastest, frame.detect_seconds);
  }
  frame.detect_seconds = fastest;
  return frame;
}

PairTruth Experiment::prepare(const DatasetPair& pair, int rounds, const LearnedMask& fixed) {
  frames_.erase(frames_.begin(), frames_.lower_bound(std::min(pair.reference, pair.current)));
  const cv::Size size = frame(pair.reference, rounds).features.image_size;
  frame(pair.current, rounds, fixed);
  if (set_.dataset.intrinsics() && camera_.imageSize() != size) {
    camera_ = Camera(*set_.dataset.intrinsics(), size);
    for (MatchFilter& filter : filters_) filter.setCamera(camera_);
  }
  return {set_.dataset, pair, camera_, set_.noise};
}

json Experiment::record(const DatasetPair& pair, const PairTruth& truth, const MatchFilterOptions& options,
                        const MatchResult& result) const {
  const Answer answer = {options, frames_.at(pair.reference).features, frames_.at(pair.current).features, result,
                         truth};
  json record = recordOf(answer);
  if (correspondences_) record["correspondences"] = correspondencesOf(answer);
  record["kind"] = set_.noise.exact() ? "rendered" : "real";
  record["set"] = set_.dataset.name();
  record["reference"] = set_.dataset.frames()[static_cast<size_t>(pair.reference)].name;
  record["current"] = set_.dataset.frames()[static_cast<size_t>(pair.current)].name;
  record["repeat"] = options.robust.seed - first_seed_;
  record["gap"] = record["reference_stamp"] = record["stamp"] = nullptr;
  if (const auto stamp = set_.dataset.stamp(pair.current)) {
    record["gap"] = gap_;
    record["reference_stamp"] = *set_.dataset.stamp(pair.reference);
    record["stamp"] = *stamp;
  }
  return record;
}

Records Experiment::run(const DatasetPair& pair, const DatasetPair* next) {
  if (next) readAhead(*next);
  // Pairs a gap of n apart are n streams, one in the other.
  const auto before = pasts_.find(pair.reference);
  std::vector<Past> pasts = before == pasts_.end() ? std::vector<Past>(filters_.size()) : before->second;
  const PairTruth truth = prepare(pair, 1, pasts.front().mask);
  Records records;
  for (size_t i = 0; i < filters_.size(); ++i) {
    filters_[i].filter(frames_[pair.reference], frames_[pair.current], result_, nullptr, &pasts[i]);
    records.push_back(record(pair, truth, filters_[i].options(), result_));
  }
  pasts_.erase(pasts_.begin(), pasts_.lower_bound(std::min(pair.reference, pair.current)));
  pasts_[pair.current] = std::move(pasts);
  return records;
}

Records Experiment::time(const DatasetPair& pair, int seeds) {
  const PairTruth truth = prepare(pair, kRounds);
  const Frame &reference = frames_[pair.reference], &current = frames_[pair.current];
  std::vector<MatchResult> results(filters_.size());
  std::vector<StageTimes> fastest(filters_.size());
  for (int round = 0; round < kRounds; ++round) {
    for (size_t i = 0; i < filters_.size(); ++i) {
      filters_[i].filter(reference, current, results[i]);
      const StageTimes& times = results[i].times;
      if (round == 0) fastest[i] = times;
      fastest[i].match = std::min(fastest[i].match, times.match);
      fastest[i].gms = std::min(fastest[i].gms, times.gms);
    }
  }
  Records records;
  for (int repeat = 0; repeat < seeds; ++repeat) {
    for (size_t i = 0; i < filters_.size(); ++i) {
      MatchFilterOptions options = filters_[i].options();
      options.robust.seed = first_seed_ + static_cast<uint64_t>(repeat);
      MatchFilterHooks::setSeed(filters_[i], options.robust.seed);
      const double start = secondsOf(CLOCK_THREAD_CPUTIME_ID);
      MatchFilterHooks::estimate(filters_[i], reference, current, results[i]);
      fastest[i].ransac = secondsOf(CLOCK_THREAD_CPUTIME_ID) - start;
      results[i].times = fastest[i];
      records.push_back(record(pair, truth, options, results[i]));
      records.back().erase("covariance");  // the tables have no use for it
    }
  }
  return records;
}

/// Names the pair of a record that has no images and no stamps.
void name(const std::string& set, size_t pair, json& record) {
  record.update({{"set", set}, {"reference", ""}, {"current", std::to_string(pair)}});
  record["gap"] = record["reference_stamp"] = record["stamp"] = nullptr;
}

/// Records of the estimators' answers to a drawn pair.
Records drawnRecords(const TwoViewScene& scene, const std::string& set, size_t pair, const Pipelines& pipelines) {
  Records records;
  for (const MatchFilterOptions& options : pipelines) {
    json& record = records.emplace_back(recordOf(options, *makeMethod(options), scene));
    name(set, pair, record);
  }
  return records;
}

/// Runs pipelines over drawn sequences, one after the other.
class SequenceExperiment {
 public:
  SequenceExperiment(const DrawnSequence& sequence, const Pipelines& pipelines)
      : sequence_(sequence), pasts_(pipelines.size()) {
    for (const MatchFilterOptions& options : pipelines) {
      filters_.emplace_back(options);
      filters_.back().setCamera(sceneCamera());
    }
  }

  Records run(size_t pair) {
    const size_t index = pair / kPairsOfSequence, k = pair % kPairsOfSequence;
    if (images_.empty() || index != index_) {
      index_ = index;
      images_ = drawSequence(sequence_, static_cast<int>(index));
      std::fill(pasts_.begin(), pasts_.end(), Past());
    }
    const Frame reference(images_[k].features, kSequenceInterval * static_cast<double>(k));
    const Frame current(images_[k + 1].features, kSequenceInterval * static_cast<double>(k + 1));
    Records records;
    for (size_t i = 0; i < filters_.size(); ++i) {
      filters_[i].filter(reference, current, result_, nullptr, &pasts_[i]);
      json& record = records.emplace_back(
          recordOf(filters_[i].options(), result_, images_[k].pose.inverse() * images_[k + 1].pose));
      name(sequence_.name, pair, record);
    }
    return records;
  }

 private:
  const DrawnSequence& sequence_;
  std::vector<MatchFilter> filters_;
  std::vector<Past> pasts_;
  size_t index_ = 0;  ///< of the sequence whose images are drawn
  std::vector<DrawnImage> images_;
  MatchResult result_;
};

}  // namespace

Series pairSeries(const MeasuredSet& set, int gap, int stride, const Pipelines& pipelines, bool correspondences) {
  const std::vector<DatasetPair> pairs = set.dataset.pairs(gap, stride);
  const bool listed = set.dataset.kind() == DatasetKind::kImagePairs;
  if (pairs.empty()) std::cerr << set.dataset.name() << " has no images " << gap << " apart\n";
  return {set.dataset.name() + (listed ? "" : ", gap " + std::to_string(gap)), pairs.size(),
          [=, &set, &pipelines] {
            const auto experiment = std::make_shared<Experiment>(set, pipelines, gap, correspondences);
            return [=](size_t pair) {
              return experiment->run(pairs[pair], pair + 1 < pairs.size() ? &pairs[pair + 1] : nullptr);
            };
          },
          listed ? 0 : kPairsBefore * static_cast<size_t>(gap)};
}

Series timedSeries(const MeasuredSet& set, int gap, int count, const Pipelines& pipelines, int seeds) {
  const std::vector<DatasetPair> pairs = set.dataset.spreadPairs(gap, count);
  return {set.dataset.name() + ", " + std::to_string(pipelines.front().extractor.features) + " features", pairs.size(),
          [=, &set, &pipelines] {
            const auto experiment = std::make_shared<Experiment>(set, pipelines, gap, false);
            return [=](size_t pair) { return experiment->time(pairs[pair], seeds); };
          }};
}

Series drawnSeries(const DrawnScene& drawn, int count, const Pipelines& pipelines) {
  const auto answer = [&](size_t pair) {
    return drawnRecords(drawPair(drawn, static_cast<int>(pair)), drawn.name, pair, pipelines);
  };
  return {drawn.name, static_cast<size_t>(count), [answer] { return std::function<Records(size_t)>(answer); }};
}

Series sequenceSeries(const DrawnSequence& sequence, int pairs, const Pipelines& pipelines) {
  const size_t sequences = std::max<size_t>(1, static_cast<size_t>(pairs) / kPairsOfSequence);
  return {sequence.name, sequences * kPairsOfSequence,
          [&] {
            const auto experiment = std::make_shared<SequenceExperiment>(sequence, pipelines);
            return [=](size_t pair) { return experiment->run(pair); };
          },
          kPairsOfSequence - 1};
}

Series outlierSeries(double outlier_ratio, int count, const Pipelines& pipelines) {
  const auto answer = [=](size_t pair) {
    TwoViewSceneOptions options;
    options.noise_px = kSweepNoise;
    options.outlier_ratio = outlier_ratio;
    options.seed = pipelines.front().robust.seed + pair;
    Pipelines seeded = pipelines;
    for (MatchFilterOptions& method : seeded) method.robust.seed = options.seed;
    Records records = drawnRecords(makeTwoViewScene(options), "outliers", pair, seeded);
    for (json& record : records) record["outlier_ratio"] = outlier_ratio;
    return records;
  };
  return {"outliers", static_cast<size_t>(count), [answer] { return std::function<Records(size_t)>(answer); }};
}

void Series::measure(size_t first, size_t last, const std::function<bool(Records&)>& receive) const {
  const auto answer = begin();
  for (size_t pair = first - std::min(first, lead); pair < last; ++pair) {
    Records records = answer(pair);
    if (pair >= first && !receive(records)) return;
  }
}

int stream(const std::vector<Series>& all, const std::string& unit, const std::vector<std::string>& report,
           const std::string& out) {
  size_t count = 0, done = 0;
  for (const Series& series : all) count += series.count;
  if (count == 0) throw std::invalid_argument("there is no " + unit + " to evaluate");
  Reporter reporter(report, out);
  watchInterrupts();
  {
    Progress progress("evaluating " + unit, static_cast<int>(count));
    for (size_t i = 0; i < all.size() && !interrupted(); ++i) {
      all[i].measure(0, all[i].count, [&](Records& records) {
        for (json& record : records) {
          const std::string line = record.dump();
          // Python would take longer to read them than the pair took, and the tables have no use for them.
          const bool shorter = record.erase("correspondences") > 0;
          reporter.add(line, shorter ? record.dump() : line);
        }
        progress.advance(all.size() > 1 ? all[i].name : "");
        ++done;
        return !interrupted();
      });
    }
  }
  return statusOrInterrupted(reporter.finish(), "the table is of the first " + std::to_string(done) + " of " +
                                                    std::to_string(count) + " " + unit + "s");
}

}  // namespace gms_ransac
