#include "tables/measurement_set.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

namespace gms_ransac {

namespace {

template <typename Value>
void addOnce(std::vector<Value>& values, const Value& value) {
  if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

}  // namespace

std::vector<double> inliersOf(const Measurement& m) { return m.inliers; }
std::vector<double> hypothesesOf(const Measurement& m) { return m.hypotheses; }
std::vector<double> pointEvaluationsOf(const Measurement& m) { return m.point_evaluations; }

std::vector<double> filterTimesOf(const Measurement& m) {
  std::vector<double> times = m.ransac_ms;
  for (double& time : times) time += m.gms_ms;
  return times;
}

std::vector<double> totalTimesOf(const Measurement& m) {
  std::vector<double> times = filterTimesOf(m);
  for (double& time : times) time += m.detect_ms + m.match_ms;
  return times;
}

double gmsSurvivors(const Measurement& m) { return m.matches_gms; }

MeasurementSet::MeasurementSet(const std::vector<Measurement>& all) {
  for (const Measurement& measurement : all) chosen_.push_back(&measurement);
}

template <typename Keep>
MeasurementSet MeasurementSet::where(const Keep& keep) const {
  MeasurementSet result;
  for (const Measurement* m : chosen_) {
    if (keep(*m)) result.chosen_.push_back(m);
  }
  return result;
}

MeasurementSet MeasurementSet::of(const std::string& sequence) const {
  return where([&](const Measurement& m) { return m.sequence == sequence; });
}
MeasurementSet MeasurementSet::at(int preset) const {
  return where([&](const Measurement& m) { return m.preset == preset; });
}
MeasurementSet MeasurementSet::with(const std::string& method) const {
  return where([&](const Measurement& m) { return m.method == method; });
}
MeasurementSet MeasurementSet::model(const std::string& name) const {
  return where([&](const Measurement& m) { return m.model == name; });
}
MeasurementSet MeasurementSet::ratio(double value) const {
  return where([&](const Measurement& m) { return std::abs(m.ratio - value) < 1e-9; });
}

std::vector<std::string> MeasurementSet::sequences() const {
  std::vector<std::string> names;
  for (const Measurement* m : chosen_) addOnce(names, m->sequence);
  return names;
}
std::vector<std::string> MeasurementSet::methods() const {
  std::vector<std::string> names;
  for (const Measurement* m : chosen_) addOnce(names, m->method);
  return names;
}
std::vector<std::string> MeasurementSet::models() const {
  std::vector<std::string> names;
  for (const Measurement* m : chosen_) addOnce(names, m->model);
  return names;
}
std::vector<std::string> MeasurementSet::pairs() const {
  std::vector<std::string> names;
  for (const Measurement* m : chosen_) addOnce(names, m->pair);
  return names;
}
std::vector<int> MeasurementSet::presets() const {
  std::set<int> values;
  for (const Measurement* m : chosen_) values.insert(m->preset);
  return {values.begin(), values.end()};
}
std::vector<double> MeasurementSet::ratios() const {
  std::set<double> values;
  for (const Measurement* m : chosen_) values.insert(m->ratio);
  return {values.begin(), values.end()};
}

std::string MeasurementSet::mainModel() const {
  std::map<std::string, int> uses;
  for (const Measurement* m : chosen_) ++uses[m->model];
  std::string main;
  for (const auto& [name, count] : uses) {
    if (main.empty() || count > uses[main]) main = name;
  }
  return main;
}

std::vector<double> MeasurementSet::pooled(std::vector<double> Measurement::*column) const {
  return pooled([column](const Measurement& m) { return m.*column; });
}

std::vector<double> MeasurementSet::pooled(const MeasurementColumn& column) const {
  std::vector<double> values;
  for (const Measurement* m : chosen_) {
    const std::vector<double> part = column(*m);
    values.insert(values.end(), part.begin(), part.end());
  }
  return values;
}

std::vector<double> MeasurementSet::single(const std::function<double(const Measurement&)>& value) const {
  std::vector<double> values;
  for (const Measurement* m : chosen_) values.push_back(value(*m));
  return values;
}

std::vector<double> MeasurementSet::truePrecision() const {
  return pooled([](const Measurement& m) {
    std::vector<double> values;
    for (size_t i = 0; i < m.correct.size(); ++i) {
      if (m.known[i] > 0) values.push_back(100.0 * m.correct[i] / m.known[i]);
    }
    return values;
  });
}

std::vector<double> MeasurementSet::trueRecall() const {
  return pooled([](const Measurement& m) {
    std::vector<double> values;
    for (double points : m.points) {
      if (m.raw_points > 0) values.push_back(100.0 * points / m.raw_points);
    }
    return values;
  });
}

std::vector<double> MeasurementSet::paperPrecisions() const {
  return pooled([](const Measurement& m) {
    std::vector<double> values;
    for (double inliers : m.inliers) {
      if (m.matches_gms > 0) values.push_back(paperPrecision(inliers, m.matches_gms));
    }
    return values;
  });
}

std::vector<double> MeasurementSet::paperRecalls() const {
  return pooled([](const Measurement& m) {
    std::vector<double> values;
    for (double inliers : m.inliers) values.push_back(paperRecall(inliers, m.preset));
    return values;
  });
}

PairedDifference meanReduction(const MeasurementSet& base, const MeasurementSet& ours,
                               const MeasurementColumn& column) {
  const std::vector<std::string> pairs = ours.pairs();
  const std::vector<int> presets = ours.presets();
  // medians[preset][pair] of {base, ours}; NaN where a unit was not measured.
  std::vector<std::vector<std::pair<double, double>>> medians;
  for (const int preset : presets) {
    const MeasurementSet base_here = base.at(preset), ours_here = ours.at(preset);
    medians.emplace_back();
    for (const std::string& pair : pairs) {
      const auto isPair = [&](const Measurement& m) { return m.pair == pair ? column(m) : std::vector<double>(); };
      medians.back().emplace_back(median(base_here.pooled(isPair)), median(ours_here.pooled(isPair)));
    }
  }
  return bootstrapOverPairs(pairs.size(), [&](const std::vector<size_t>& picks) {
    std::vector<double> reductions;
    for (const auto& row : medians) {
      std::vector<double> of_base, of_ours;
      for (const size_t pick : picks) {
        if (std::isnan(row[pick].first) || std::isnan(row[pick].second)) continue;
        of_base.push_back(row[pick].first);
        of_ours.push_back(row[pick].second);
      }
      const double base_median = median(of_base);
      if (base_median > 0) reductions.push_back(reduction(base_median, median(of_ours)));
    }
    return mean(reductions);
  });
}

std::string decimalText(double value, int decimals) {
  if (std::isnan(value)) return "-";
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

}  // namespace gms_ransac
