#include "tables/tables_report.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <utility>

#include "program.h"
#include "tables/measurement_set.h"
#include "tables/paper_figures.h"

namespace gms_ransac {

namespace {

using Row = std::vector<std::string>;

void appendSpread(Row& row, const std::vector<double>& values, int decimals) {
  const Spread s = spread(values);
  for (double value : {s.median, s.p10, s.p90}) row.push_back(decimalText(value, decimals));
}

TextTable presetTable(const MeasurementSet& all) {
  TextTable table;
  table.name = "table1";
  table.title =
      "Table 1 and Figure 5: cp_ransac at ratio 1/2 for growing presets; medians, p10 and p90 over pairs and seeds";
  table.columns = {"sequence",      "preset",        "matches",    "matches p10",   "matches p90",       "GMS",
                   "precision",     "recall",        "hypotheses", "models scored", "point evaluations", "filter ms",
                   "filter p10 ms", "filter p90 ms", "total ms",   "paper matches", "paper ms"};
  for (const auto& sequence : all.sequences()) {
    for (const int preset : all.presets()) {
      const MeasurementSet set =
          all.of(sequence).at(preset).with("cp_ransac").model(all.mainModel()).ratio(kPaperRatio);
      if (set.empty()) continue;
      Row row = {sequence, std::to_string(preset)};
      appendSpread(row, set.pooled(&Measurement::inliers), 0);
      row.push_back(decimalText(median(set.single(gmsSurvivors)), 0));
      row.push_back(decimalText(mean(set.truePrecision()), 2));
      row.push_back(decimalText(mean(set.trueRecall()), 2));
      row.push_back(decimalText(median(set.pooled(&Measurement::hypotheses)), 0));
      row.push_back(decimalText(median(set.pooled(&Measurement::models_scored)), 0));
      row.push_back(decimalText(median(set.pooled(&Measurement::point_evaluations)), 0));
      appendSpread(row, set.filterTimes(), 3);
      row.push_back(decimalText(median(set.totalTimes()), 2));
      const PaperPreset* paper = paperPreset(preset);
      row.push_back(paper ? decimalText(paper->matches, 0) : "-");
      row.push_back(paper ? decimalText(paper->milliseconds, 2) : "-");
      table.rows.push_back(row);
    }
  }
  return table;
}

TextTable ratioTable(const MeasurementSet& all) {
  TextTable table;
  table.name = "table2_3";
  table.title =
      "Tables 2 and 3 and Figure 6: cp_ransac at each grouping ratio; medians, p10 and p90 over pairs and seeds";
  table.columns = {"sequence",      "preset",        "ratio",          "matches",        "matches p10",
                   "matches p90",   "hypotheses",    "hypotheses p10", "hypotheses p90", "filter ms",
                   "filter p10 ms", "filter p90 ms", "paper matches",  "paper ms"};
  for (const auto& sequence : all.sequences()) {
    for (const int preset : all.presets()) {
      for (const double ratio : all.ratios()) {
        const MeasurementSet set = all.of(sequence).at(preset).with("cp_ransac").model(all.mainModel()).ratio(ratio);
        if (set.empty()) continue;
        Row row = {sequence, std::to_string(preset), ratioName(ratio)};
        appendSpread(row, set.pooled(&Measurement::inliers), 0);
        appendSpread(row, set.pooled(&Measurement::hypotheses), 0);
        appendSpread(row, set.filterTimes(), 3);
        const PaperPreset paper = paperRatio(preset, ratioName(ratio));
        row.push_back(paper.matches > 0 ? decimalText(paper.matches, 0) : "-");
        row.push_back(paper.matches > 0 ? decimalText(paper.milliseconds, 2) : "-");
        table.rows.push_back(row);
      }
    }
  }
  return table;
}

TextTable precisionTable(const MeasurementSet& all) {
  TextTable table;
  table.name = "table4";
  table.title = "Table 4: 2000 features; the paper's ratios beside true precision, recall and pose errors";
  table.columns = {"sequence",
                   "model",
                   "method",
                   "GMS",
                   "kept",
                   "paper precision %",
                   "paper precision p10 %",
                   "paper precision p90 %",
                   "paper recall %",
                   "precision %",
                   "recall %",
                   "AUC5",
                   "AUC10",
                   "AUC20",
                   "RAUC2",
                   "hypotheses",
                   "in the paper's 62-82 %"};
  for (const auto& sequence : all.sequences()) {
    for (const auto& model : all.models()) {
      for (const auto& method : all.methods()) {
        const MeasurementSet set = all.of(sequence).at(kTable4Preset).model(model).with(method).ratio(kPaperRatio);
        if (set.empty()) continue;
        const Spread precision = spread(set.paperPrecisions());
        Row row = {sequence, model, method};
        row.push_back(decimalText(median(set.single(gmsSurvivors)), 0));
        row.push_back(decimalText(median(set.pooled(&Measurement::inliers)), 0));
        for (double value : {precision.median, precision.p10, precision.p90}) row.push_back(decimalText(value, 2));
        row.push_back(decimalText(median(set.paperRecalls()), 2));
        row.push_back(decimalText(mean(set.truePrecision()), 2));
        row.push_back(decimalText(mean(set.trueRecall()), 2));
        const std::vector<double> errors = set.pooled(&Measurement::pose_error);
        for (double limit : {5.0, 10.0, 20.0}) {
          row.push_back(errors.empty() ? "-" : decimalText(areaUnderRecallCurve(errors, limit), 2));
        }
        const std::vector<double> rotations = set.pooled(&Measurement::rotation_error);
        row.push_back(rotations.empty() ? "-" : decimalText(areaUnderRecallCurve(rotations, 2), 2));
        row.push_back(decimalText(median(set.pooled(&Measurement::hypotheses)), 0));
        const bool inside = precision.median >= kPaperLowestPrecision && precision.median <= kPaperHighestPrecision;
        row.push_back(inside ? "yes" : "no");
        table.rows.push_back(row);
      }
    }
  }
  return table;
}

/// What is compared with which baseline, each two once; cp_ransac and lo_prosac are never a baseline.
std::vector<std::pair<std::string, std::string>> comparisons(const MeasurementSet& set) {
  const auto isBaseline = [](const std::string& name) { return name != "cp_ransac" && name != "lo_prosac"; };
  const std::vector<std::string> names = set.methods();
  std::vector<std::pair<std::string, std::string>> found;
  for (size_t i = 0; i < names.size(); ++i) {
    for (size_t j = 0; j < names.size(); ++j) {
      if (i != j && isBaseline(names[j]) && (i < j || !isBaseline(names[i]))) found.emplace_back(names[i], names[j]);
    }
  }
  return found;
}

/// "31.2 [28.0, 34.1]"
std::string withInterval(const PairedDifference& figure) {
  return decimalText(figure.difference, 2) + " [" + decimalText(figure.low, 2) + ", " + decimalText(figure.high, 2) +
         "]";
}

using PairColumns = std::vector<std::vector<double>>;

std::vector<double> percentages(const std::vector<double>& parts, double whole) {
  std::vector<double> values = parts;
  for (double& value : values) value *= 100 / whole;
  return values;
}

/// Of the current points, in each repetition, percent; nothing when no raw match is correct.
std::vector<double> recallOf(const Measurement& m) {
  return m.raw_points > 0 ? percentages(m.points, m.raw_points) : std::vector<double>();
}

std::vector<double> paperPrecisionOf(const Measurement& m) {
  return m.matches_gms > 0 ? percentages(m.inliers, m.matches_gms) : std::vector<double>();
}

/// ours - base of a figure of the pooled repetitions of pairs; "-" where nothing was measured.
std::string differenceText(const MeasurementSet& ours, const MeasurementSet& base, const MeasurementColumn& column,
                           const std::function<double(const std::vector<double>&)>& figure) {
  const std::vector<std::string> pairs = ours.pairs();
  PairColumns of_ours, of_base;
  for (const std::string& pair : pairs) {
    const auto of_pair = [&](const Measurement& m) { return m.pair == pair ? column(m) : std::vector<double>(); };
    of_ours.push_back(ours.pooled(of_pair));
    of_base.push_back(base.pooled(of_pair));
  }
  const auto pooled = [](const PairColumns& columns, const std::vector<size_t>& picks) {
    std::vector<double> values;
    for (const size_t pick : picks) values.insert(values.end(), columns[pick].begin(), columns[pick].end());
    return values;
  };
  if (ours.pooled(column).empty() || base.pooled(column).empty()) return "-";
  return withInterval(bootstrapOverPairs(pairs.size(), [&](const std::vector<size_t>& picks) {
    return figure(pooled(of_ours, picks)) - figure(pooled(of_base, picks));
  }));
}

TextTable accuracyTable(const MeasurementSet& all) {
  TextTable table;
  table.name = "table4_differences";
  table.title =
      "Table 4, differences: method less baseline at 2000 features, points, with its 95 % interval over pairs";
  table.columns = {"sequence", "model", "method", "baseline", "paper precision", "recall", "AUC10", "RAUC2"};
  const auto area = [](double limit) {
    return [limit](const std::vector<double>& errors) { return areaUnderRecallCurve(errors, limit); };
  };
  for (const auto& sequence : all.sequences()) {
    for (const auto& model : all.models()) {
      const MeasurementSet set = all.of(sequence).at(kTable4Preset).model(model).ratio(kPaperRatio);
      for (const auto& [method, baseline] : comparisons(set)) {
        const MeasurementSet ours = set.with(method), base = set.with(baseline);
        table.rows.push_back({sequence, model, method, baseline, differenceText(ours, base, paperPrecisionOf, mean),
                              differenceText(ours, base, recallOf, mean),
                              differenceText(
                                  ours, base, [](const Measurement& m) { return m.pose_error; }, area(10)),
                              differenceText(
                                  ours, base, [](const Measurement& m) { return m.rotation_error; }, area(2))});
      }
    }
  }
  return table;
}

TextTable reductionTable(const MeasurementSet& all) {
  TextTable table;
  table.name = "table5";
  table.title =
      "Table 5: reduction against each baseline, percent, mean over presets with its 95 % interval over pairs";
  table.columns = {"sequence",        "method",          "baseline", "hypotheses", "point evaluations",
                   "robust-stage ms", "filter-stage ms", "total ms", "paper ms"};
  for (const auto& sequence : all.sequences()) {
    const MeasurementSet set = all.of(sequence).model(all.mainModel()).ratio(kPaperRatio);
    for (const auto& [method, baseline] : comparisons(set)) {
      const MeasurementSet ours = set.with(method), base = set.with(baseline);
      Row row = {sequence, method, baseline};
      row.push_back(withInterval(meanReduction(base, ours, hypothesesOf)));
      row.push_back(withInterval(meanReduction(base, ours, pointEvaluationsOf)));
      row.push_back(withInterval(meanReduction(base, ours, [](const Measurement& m) { return m.ransac_ms; })));
      row.push_back(withInterval(meanReduction(base, ours, filterTimesOf)));
      row.push_back(withInterval(meanReduction(base, ours, totalTimesOf)));
      row.push_back(method == "cp_ransac" ? paperReduction(baseline) : "-");
      table.rows.push_back(row);
    }
  }
  return table;
}

TextTable ratioSignificanceTable(const MeasurementSet& all) {
  TextTable table;
  table.name = "ratio_significance";
  table.title =
      "Change of each ratio against the paper's 1/2, percent (positive: fewer), mean over presets with its 95 % "
      "interval over pairs; an interval that holds 0 shows no difference";
  table.columns = {"sequence", "ratio", "matches", "hypotheses", "filter-stage ms"};
  for (const auto& sequence : all.sequences()) {
    const MeasurementSet set = all.of(sequence).model(all.mainModel()).with("cp_ransac");
    const MeasurementSet base = set.ratio(kPaperRatio);
    for (const double ratio : all.ratios()) {
      const MeasurementSet ours = set.ratio(ratio);
      if (ratio == kPaperRatio || ours.empty() || base.empty()) continue;
      table.rows.push_back({sequence, ratioName(ratio), withInterval(meanReduction(base, ours, inliersOf)),
                            withInterval(meanReduction(base, ours, hypothesesOf)),
                            withInterval(meanReduction(base, ours, filterTimesOf))});
    }
  }
  return table;
}

TextTable methodTrendTable(const MeasurementSet& all) {
  TextTable table;
  table.name = "fig8_9";
  table.title = "Figures 8 and 9: matches and time of each method for growing presets; medians over pairs and seeds";
  table.columns = {"sequence", "preset",     "method",    "matches",       "matches p10",   "matches p90",
                   "correct",  "hypotheses", "filter ms", "filter p10 ms", "filter p90 ms", "total ms"};
  for (const auto& sequence : all.sequences()) {
    for (const int preset : all.presets()) {
      for (const auto& method : all.methods()) {
        const MeasurementSet set = all.of(sequence).at(preset).with(method).model(all.mainModel()).ratio(kPaperRatio);
        if (set.empty()) continue;
        Row row = {sequence, std::to_string(preset), method};
        appendSpread(row, set.pooled(&Measurement::inliers), 0);
        row.push_back(decimalText(median(set.pooled(&Measurement::correct)), 0));
        row.push_back(decimalText(median(set.pooled(&Measurement::hypotheses)), 0));
        appendSpread(row, set.filterTimes(), 3);
        row.push_back(decimalText(median(set.totalTimes()), 2));
        table.rows.push_back(row);
      }
    }
  }
  return table;
}

std::string joined(const Row& cells, const std::string& separator) {
  std::string text;
  for (size_t i = 0; i < cells.size(); ++i) text += (i ? separator : "") + cells[i];
  return text;
}

/// Commas only occur inside intervals; such a cell is quoted.
Row quoted(Row cells) {
  for (std::string& cell : cells) {
    if (cell.find(',') != std::string::npos) cell = "\"" + cell + "\"";
  }
  return cells;
}

void writeFile(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  if (!(file << text).flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace

std::vector<TextTable> makeTables(const std::vector<Measurement>& measurements) {
  const MeasurementSet all(measurements);
  return {presetTable(all),     ratioTable(all),     precisionTable(all),
          accuracyTable(all),   reductionTable(all), ratioSignificanceTable(all),
          methodTrendTable(all)};
}

std::string toCsv(const TextTable& table) {
  std::string text = joined(quoted(table.columns), ",") + "\n";
  for (const Row& row : table.rows) text += joined(quoted(row), ",") + "\n";
  return text;
}

std::string toMarkdown(const TextTable& table) {
  std::string text =
      "| " + joined(table.columns, " | ") + " |\n|" + joined(Row(table.columns.size(), "---"), "|") + "|\n";
  for (const Row& row : table.rows) text += "| " + joined(row, " | ") + " |\n";
  return text;
}

void writeTables(const std::string& folder, const std::string& heading, const std::vector<TextTable>& tables) {
  std::string markdown = heading;
  for (const TextTable& table : tables) {
    writeFile(folder + "/" + table.name + ".csv", toCsv(table));
    markdown += "\n## " + table.title + "\n\n" + toMarkdown(table);
  }
  writeFile(folder + "/tables.md", markdown);
}

void plotTables(const std::string& folder_or_sweep) {
  runScript("plot_tables.py", folder_or_sweep, "no plots, but the tables are complete");
}

}  // namespace gms_ransac
