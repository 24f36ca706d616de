#include "run/summary.h"

#include <cmath>
#include <cstdio>

namespace gms_ransac {

namespace {

template <typename Column>
double medianOf(const std::vector<PairOutcome>& outcomes, const Column& column) {
  std::vector<double> values;
  values.reserve(outcomes.size());
  for (const PairOutcome& outcome : outcomes) values.push_back(static_cast<double>(column(outcome)));
  return median(values);
}

/// The truth by which matches are judged where a set has both: epipolar, as is usual.
const std::optional<MatchCounts>& matchTruth(const PairOutcome& outcome) {
  return outcome.epipolar ? outcome.epipolar : outcome.transfer;
}

std::string cell(double value, int width, int decimals) {
  char text[64];
  if (std::isnan(value)) {
    std::snprintf(text, sizeof(text), "%*s", width, "-");
  } else {
    std::snprintf(text, sizeof(text), "%*.*f", width, decimals, value);
  }
  return text;
}

}  // namespace

PairOutcome outcomeOf(const Record& record) {
  PairOutcome outcome;
  outcome.has_true_pose = record.score.has_true_pose;
  outcome.has_pose = record.has_pose;
  outcome.ok = record.status == toString(Status::kOk);
  if (record.score.pose) outcome.error = *record.score.pose;
  outcome.epipolar = record.score.epipolar;
  outcome.transfer = record.score.transfer;
  outcome.features = record.context.features;
  outcome.matches_raw = record.matches_raw;
  outcome.matches_gms = record.matches_gms;
  outcome.inliers = record.inliers;
  outcome.hypotheses = record.hypotheses;
  outcome.models_scored = record.models_scored;
  outcome.point_evaluations = record.point_evaluations;
  outcome.times = record.times;
  return outcome;
}

Summary summarize(const std::vector<PairOutcome>& outcomes) {
  Summary summary;
  std::vector<double> worst, rotation, rotation_answered, precision, recall, kept, correct, paper_precision,
      paper_recall;
  for (const PairOutcome& outcome : outcomes) {
    ++summary.pairs;
    summary.answered += outcome.has_pose;
    summary.ok += outcome.ok;
    if (outcome.has_true_pose) {
      worst.push_back(outcome.error.worst());
      rotation.push_back(outcome.error.rotation);
      if (outcome.has_pose) rotation_answered.push_back(outcome.error.rotation);
    }
    const double gms_ratio = paperPrecision(outcome.inliers, outcome.matches_gms);
    if (!std::isnan(gms_ratio)) paper_precision.push_back(gms_ratio);
    paper_recall.push_back(paperRecall(outcome.inliers, outcome.features));
    const std::optional<MatchCounts>& truth = matchTruth(outcome);
    // As in the usual evaluation a pair without a pose has no kept matches to judge, unless poses do not apply.
    if (!truth || (outcome.has_true_pose && !outcome.has_pose)) continue;
    kept.push_back(outcome.inliers);
    correct.push_back(truth->kept_correct);
    if (truth->kept_known > 0) precision.push_back(100.0 * truth->precision());
    if (truth->raw_points > 0) recall.push_back(100.0 * truth->recall());
  }
  const double none = median({});
  const bool posed = !worst.empty();
  summary.auc5 = posed ? areaUnderRecallCurve(worst, 5) : none;
  summary.auc10 = posed ? areaUnderRecallCurve(worst, 10) : none;
  summary.auc20 = posed ? areaUnderRecallCurve(worst, 20) : none;
  summary.rotation_auc2 = posed ? areaUnderRecallCurve(rotation, 2) : none;
  summary.rotation_median = median(rotation_answered);
  summary.precision = mean(precision);
  summary.recall = mean(recall);
  summary.kept = kept.empty() ? medianOf(outcomes, [](const PairOutcome& o) { return o.inliers; }) : median(kept);
  summary.correct = median(correct);
  summary.paper_precision = median(paper_precision);
  summary.paper_recall = median(paper_recall);
  summary.hypotheses = medianOf(outcomes, [](const PairOutcome& o) { return o.hypotheses; });
  summary.models_scored = medianOf(outcomes, [](const PairOutcome& o) { return o.models_scored; });
  summary.point_evaluations = medianOf(outcomes, [](const PairOutcome& o) { return o.point_evaluations; });
  summary.detect_ms = medianOf(outcomes, [](const PairOutcome& o) { return 1e3 * o.times.detect; });
  summary.match_ms = medianOf(outcomes, [](const PairOutcome& o) { return 1e3 * o.times.match; });
  summary.gms_ms = medianOf(outcomes, [](const PairOutcome& o) { return 1e3 * o.times.gms; });
  summary.ransac_ms = medianOf(outcomes, [](const PairOutcome& o) { return 1e3 * o.times.ransac; });
  summary.total_ms = medianOf(outcomes, [](const PairOutcome& o) { return 1e3 * o.times.total(); });
  return summary;
}

std::string summaryTable(const std::vector<std::pair<std::string, Summary>>& rows) {
  std::string text =
      "method            pairs posed   AUC5  AUC10  AUC20  RAUC2  R med deg  prec %  recall %   kept correct  hypoth."
      "  detect   match     gms  ransac  total ms\n";
  for (const auto& [name, s] : rows) {
    char head[64];
    std::snprintf(head, sizeof(head), "%-17s %5d %5d", name.c_str(), s.pairs, s.answered);
    text += head + cell(s.auc5, 7, 1) + cell(s.auc10, 7, 1) + cell(s.auc20, 7, 1) + cell(s.rotation_auc2, 7, 1) +
            cell(s.rotation_median, 11, 3) + cell(s.precision, 8, 2) + cell(s.recall, 10, 2) + cell(s.kept, 7, 0) +
            cell(s.correct, 8, 0) + cell(s.hypotheses, 9, 0) + cell(s.detect_ms, 8, 2) + cell(s.match_ms, 8, 2) +
            cell(s.gms_ms, 8, 3) + cell(s.ransac_ms, 8, 3) + cell(s.total_ms, 10, 2) + "\n";
  }
  return text;
}

}  // namespace gms_ransac
