// Choosing among measurements and folding their columns into figures.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "run/metrics.h"
#include "tables/tables_measure.h"

namespace gms_ransac {

/// Values of one measurement, one for each repetition.
using MeasurementColumn = std::function<std::vector<double>(const Measurement&)>;
std::vector<double> inliersOf(const Measurement& m);
std::vector<double> hypothesesOf(const Measurement& m);
std::vector<double> pointEvaluationsOf(const Measurement& m);
std::vector<double> filterTimesOf(const Measurement& m);  ///< GMS and the robust stage, milliseconds
std::vector<double> totalTimesOf(const Measurement& m);   ///< extraction to pose, milliseconds
double gmsSurvivors(const Measurement& m);

/// A view of measurements that outlive it. The choosing functions return what is left, in order.
class MeasurementSet {
 public:
  explicit MeasurementSet(const std::vector<Measurement>& all);

  MeasurementSet of(const std::string& sequence) const;
  MeasurementSet at(int preset) const;
  MeasurementSet with(const std::string& method) const;
  MeasurementSet model(const std::string& name) const;
  MeasurementSet ratio(double value) const;
  bool empty() const { return chosen_.empty(); }

  // What occurs among the measurements, in order of appearance (presets and ratios: ascending).
  std::vector<std::string> sequences() const;
  std::vector<std::string> methods() const;
  std::vector<std::string> models() const;
  std::vector<std::string> pairs() const;
  std::vector<int> presets() const;
  std::vector<double> ratios() const;
  std::string mainModel() const;  ///< the one most measurements use

  std::vector<double> pooled(std::vector<double> Measurement::*column) const;
  std::vector<double> pooled(const MeasurementColumn& column) const;
  std::vector<double> single(const std::function<double(const Measurement&)>& value) const;
  std::vector<double> filterTimes() const { return pooled(filterTimesOf); }
  std::vector<double> totalTimes() const { return pooled(totalTimesOf); }
  std::vector<double> truePrecision() const;    ///< percent, one for each repetition that kept something
  std::vector<double> trueRecall() const;       ///< percent, where a raw match is correct
  std::vector<double> paperPrecisions() const;  ///< percent
  std::vector<double> paperRecalls() const;     ///< percent

 private:
  MeasurementSet() = default;
  template <typename Keep>
  MeasurementSet where(const Keep& keep) const;

  std::vector<const Measurement*> chosen_;
};

/// Mean over presets of (base - ours) / base, percent, of the medians over pairs of each pair's median repetition; with
/// a bootstrap interval over the pairs that both sets have (the paper's Table 5).
PairedDifference meanReduction(const MeasurementSet& base, const MeasurementSet& ours, const MeasurementColumn& column);

std::string decimalText(double value, int decimals);  ///< "-" for NaN

}  // namespace gms_ransac
