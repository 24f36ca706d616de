#include "run/experiment.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <utility>

#include "program.h"

namespace gms_ransac {

namespace {

constexpr int kRounds = 3;  ///< of stages that are timed; the first one pays for memory and caches

}  // namespace

void printRemarks(const Dataset& dataset, const MatchFilterOptions& options) {
  std::cerr << dataset.path() << ": " << dataset.calibrationText() << '\n';
  if (!dataset.stamp(0) && options.robust.rolling_shutter_readout != 0) {
    std::cerr << dataset.path() << ": a list of pairs has no stamps, so --rolling-shutter-readout is not applied\n";
  }
}

Experiment::Experiment(const Dataset& dataset, const std::vector<MatchFilterOptions>& pipelines,
                       const TruthNoise& noise)
    : dataset_(dataset), noise_(noise), first_seed_(pipelines.front().robust.seed) {
  for (const MatchFilterOptions& options : pipelines) filters_.emplace_back(options);
}

const Frame& Experiment::frame(int index, int rounds) {
  const auto [place, is_new] = frames_.try_emplace(index);
  Frame& frame = place->second;
  if (!is_new) return frame;
  const cv::Mat image = dataset_.image(index);
  double fastest = std::numeric_limits<double>::infinity();
  for (int round = 0; round < rounds; ++round) {
    filters_.front().extract(image, frame, cv::Mat(), dataset_.stamp(index));
    fastest = std::min(fastest, frame.detect_seconds);
  }
  frame.detect_seconds = fastest;
  return frame;
}

PairTruth Experiment::prepare(const DatasetPair& pair, int rounds) {
  frames_.erase(frames_.begin(), frames_.lower_bound(std::min(pair.reference, pair.current)));
  const cv::Size size = frame(pair.reference, rounds).features.image_size;
  frame(pair.current, rounds);
  if (dataset_.intrinsics() && camera_.imageSize() != size) {
    camera_ = Camera(*dataset_.intrinsics(), size);
    for (MatchFilter& filter : filters_) filter.setCamera(camera_);
  }
  return {dataset_, pair, camera_, noise_};
}

void Experiment::tell(const DatasetPair& pair, int gap, const PairTruth& truth, const MatchFilterOptions& options,
                      const MatchResult& result, const Receive& receive) const {
  const Answer answer = {options, frames_.at(pair.reference).features, frames_.at(pair.current).features, result,
                         truth};
  nlohmann::json record = recordOf(answer);
  record["kind"] = noise_.exact() ? "rendered" : "real";
  record["set"] = dataset_.name();
  record["reference"] = dataset_.frames()[static_cast<size_t>(pair.reference)].name;
  record["current"] = dataset_.frames()[static_cast<size_t>(pair.current)].name;
  record["repeat"] = options.robust.seed - first_seed_;
  record["gap"] = record["reference_stamp"] = record["stamp"] = nullptr;
  if (const auto stamp = dataset_.stamp(pair.current)) {
    record["gap"] = gap;
    record["reference_stamp"] = *dataset_.stamp(pair.reference);
    record["stamp"] = *stamp;
  }
  receive(record, &answer);
}

void Experiment::run(const DatasetPair& pair, int gap, const Receive& receive) {
  const PairTruth truth = prepare(pair, 1);
  // Pairs a gap of n apart are n streams, one in the other.
  const auto before = pasts_.find(pair.reference);
  std::vector<Past> pasts = before == pasts_.end() ? std::vector<Past>(filters_.size()) : before->second;
  for (size_t i = 0; i < filters_.size(); ++i) {
    filters_[i].filter(frames_[pair.reference], frames_[pair.current], result_, nullptr, &pasts[i]);
    pasts[i].advance();
    tell(pair, gap, truth, filters_[i].options(), result_, receive);
  }
  pasts_.erase(pasts_.begin(), pasts_.lower_bound(std::min(pair.reference, pair.current)));
  pasts_[pair.current] = std::move(pasts);
}

void Experiment::time(const DatasetPair& pair, int gap, int seeds, const Receive& receive) {
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
  for (int repeat = 0; repeat < seeds; ++repeat) {
    for (size_t i = 0; i < filters_.size(); ++i) {
      MatchFilterOptions options = filters_[i].options();
      options.robust.seed = first_seed_ + static_cast<uint64_t>(repeat);
      filters_[i].setSeed(options.robust.seed);
      const double start = secondsOf(CLOCK_THREAD_CPUTIME_ID);
      filters_[i].estimate(reference, current, results[i]);
      fastest[i].ransac = secondsOf(CLOCK_THREAD_CPUTIME_ID) - start;
      results[i].times = fastest[i];
      tell(pair, gap, truth, options, results[i], receive);
    }
  }
}

}  // namespace gms_ransac
