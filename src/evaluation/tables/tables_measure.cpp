#include "tables/tables_measure.h"

#include <algorithm>
#include <ctime>
#include <limits>

#include "run/metrics.h"
#include "run/pair_truth.h"

namespace gms_ransac {

namespace {

// The stages before the robust one run this often and count with their fastest time: they do the same every time, and
// the first call pays for memory and caches.
constexpr int kStageRuns = 3;

Frame extracted(const Dataset& dataset, int index, MatchFilter& extractor) {
  const cv::Mat image = dataset.image(index);
  Frame frame;
  double fastest = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kStageRuns; ++run) {
    extractor.extract(image, frame, cv::Mat(), dataset.stamp(index));
    fastest = std::min(fastest, frame.detect_seconds);
  }
  frame.detect_seconds = fastest;
  return frame;
}

/// Processor time of this thread, milliseconds: other programs on the machine do not count.
double processorMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

MatchCounts countKept(const PairTruth& truth, const Features& reference, const Features& current,
                      const MatchResult& result) {
  if (truth.hasEpipolar()) return countEpipolar(truth, reference, current, result);
  return countTransfer(truth, reference, current, result);
}

/// Appends one repetition to the columns.
void append(const PairTruth& truth, const Frame& reference, const Frame& current, const MatchResult& result,
            Measurement& measurement) {
  measurement.inliers.push_back(result.inliers);
  measurement.hypotheses.push_back(result.robust.effort.hypotheses);
  measurement.models_scored.push_back(result.robust.effort.models_scored);
  measurement.point_evaluations.push_back(static_cast<double>(result.robust.effort.point_evaluations));
  if (truth.hasEpipolar() || truth.hasTransfer()) {
    const MatchCounts counts = countKept(truth, reference.features, current.features, result);
    measurement.raw_points = counts.raw_points;
    measurement.known.push_back(counts.kept_known);
    measurement.correct.push_back(counts.kept_correct);
    measurement.points.push_back(counts.kept_points);
  }
  if (truth.currentInReference()) {
    PoseError error;
    const bool posed = result.status == Status::kOk || result.status == Status::kLowParallax;
    if (posed) error = poseError(*truth.currentInReference(), result.robust.pose.R, result.robust.pose.t);
    measurement.rotation_error.push_back(error.rotation);
    measurement.pose_error.push_back(error.worst());
  }
}

}  // namespace

TablesMeter::TablesMeter(const TablesPlan& plan, const std::vector<Dataset>& datasets)
    : plan_(plan), datasets_(datasets) {}

MatchFilter& TablesMeter::filterFor(const TablesRun& run) {
  auto& filter = filters_[{run.method, run.model, run.ratio}];
  if (!filter) {
    MatchFilterOptions options = plan_.base;
    options.method = run.method;
    options.robust.model = run.model;
    options.robust.first_group_fraction = run.ratio;
    filter = std::make_unique<MatchFilter>(options);
  }
  return *filter;
}

std::vector<Measurement> TablesMeter::measure(const TablesUnit& unit) {
  const Dataset& dataset = datasets_[static_cast<size_t>(unit.sequence)];
  MatchFilterOptions extraction = plan_.base;
  extraction.extractor.features = unit.preset;
  if (unit.preset > kLastPresetOfDefaultFastThreshold) extraction.extractor.fast_threshold = 0;
  MatchFilter extractor(extraction);
  const Frame reference = extracted(dataset, unit.pair.reference, extractor);
  const Frame current = extracted(dataset, unit.pair.current, extractor);
  const Camera camera = dataset.intrinsics() ? Camera(*dataset.intrinsics(), reference.features.image_size) : Camera();
  const PairTruth truth(dataset, unit.pair, camera);

  const std::vector<TablesRun> runs = tablesRuns(plan_, unit.preset);
  std::vector<Measurement> measurements(runs.size());
  std::vector<MatchResult> results(runs.size());
  for (size_t i = 0; i < runs.size(); ++i) {
    Measurement& measurement = measurements[i];
    measurement.match_ms = measurement.gms_ms = std::numeric_limits<double>::infinity();
    measurement.unit = unit.index;
    measurement.sequence = dataset.name();
    measurement.pair = dataset.frames()[static_cast<size_t>(unit.pair.reference)].name + " " +
                       dataset.frames()[static_cast<size_t>(unit.pair.current)].name;
    measurement.preset = unit.preset;
    measurement.method = runs[i].method;
    measurement.model = toString(runs[i].model);
    measurement.ratio = runs[i].ratio;
  }
  // Rounds over all runs, not all rounds of a run: a disturbance then costs a run one of its rounds at most.
  for (int round = 0; round < kStageRuns; ++round) {
    for (size_t i = 0; i < runs.size(); ++i) {
      MatchFilter& filter = filterFor(runs[i]);
      filter.setCamera(camera);
      filter.filter(reference, current, results[i]);
      Measurement& measurement = measurements[i];
      measurement.matches_raw = static_cast<int>(results[i].matches.size());
      measurement.matches_gms = results[i].matches_gms;
      measurement.detect_ms = 1e3 * results[i].times.detect;
      measurement.match_ms = std::min(measurement.match_ms, 1e3 * results[i].times.match);
      measurement.gms_ms = std::min(measurement.gms_ms, 1e3 * results[i].times.gms);
    }
  }
  for (int repeat = 0; repeat < plan_.repeats; ++repeat) {
    for (size_t i = 0; i < runs.size(); ++i) {
      MatchFilter& filter = filterFor(runs[i]);
      filter.setSeed(plan_.base.robust.seed + static_cast<uint64_t>(repeat));
      filter.reset();
      const double start = processorMilliseconds();
      filter.estimate(reference, current, results[i]);
      measurements[i].ransac_ms.push_back(processorMilliseconds() - start);
      append(truth, reference, current, results[i], measurements[i]);
    }
  }
  // One denominator of recall for all, that of one-way matching: mutual matching leaves fewer to be found.
  for (Measurement& measurement : measurements) measurement.raw_points = measurements.front().raw_points;
  return measurements;
}

}  // namespace gms_ransac
