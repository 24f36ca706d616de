#include "trust/trust_json.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "run/options_json.h"

namespace gms_ransac {

namespace {

using nlohmann::json;

constexpr double kDegrees = 180 / M_PI;

/// visit(name, field) for each column, in order.
template <typename Row, typename Visit>
void forEachColumn(Row& row, const Visit& visit) {
  visit("kind", row.kind);
  visit("set", row.set);
  visit("gap", row.gap);
  visit("pair", row.pair);
  visit("method", row.method);
  visit("status", row.status);
  visit("survivors", row.survivors);
  visit("inliers", row.inliers);
  visit("has_truth", row.has_truth);
  visit("baseline_m", row.baseline_m);
  visit("moved", row.moved);
  visit("right", row.right);
  visit("wrong", row.wrong);
  visit("rotation_error_deg", row.rotation_error_deg);
  visit("direction_error_deg", row.direction_error_deg);
  visit("rx_deg", row.rx_deg);
  visit("ry_deg", row.ry_deg);
  visit("rz_deg", row.rz_deg);
  visit("rotation_sigma_deg", row.rotation_sigma_deg);
  visit("direction_sigma_deg", row.direction_sigma_deg);
  visit("uncertainty_deg", row.uncertainty_deg);
  visit("nees_rotation", row.nees_rotation);
  visit("nees_direction", row.nees_direction);
  visit("parallax_px", row.parallax_px);
  visit("sigma_px", row.sigma_px);
  visit("covariance", row.covariance);
  visit("reliability", row.reliability);
}

template <typename T>
json toJson(const T& value) {
  return value;
}

json toJson(double number) { return std::isfinite(number) ? json(number) : json(); }

json toJson(const std::vector<double>& numbers) {
  json values = json::array();
  for (const double number : numbers) values.push_back(toJson(number));
  return values;
}

json toJson(const Reliability& reliability) {
  json numbers = json::array();
  for (const Reliability::Bin& bin : reliability.bins) {
    numbers.push_back(bin.count);
    numbers.push_back(std::round(1e4 * bin.probability) / 1e4);
    numbers.push_back(bin.right);
  }
  return numbers;
}

template <typename T>
void fromJson(const json& value, T& field) {
  value.get_to(field);
}

void fromJson(const json& value, double& number) { number = value.is_null() ? TrustRow::kNone : value.get<double>(); }

void fromJson(const json& values, std::vector<double>& numbers) {
  numbers.resize(values.size());
  for (size_t i = 0; i < numbers.size(); ++i) fromJson(values[i], numbers[i]);
}

void fromJson(const json& numbers, Reliability& reliability) {
  size_t i = 0;
  for (Reliability::Bin& bin : reliability.bins) {
    numbers.at(i++).get_to(bin.count);
    numbers.at(i++).get_to(bin.probability);
    numbers.at(i++).get_to(bin.right);
  }
}

std::string cell(const json& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_string()) return '"' + value.get<std::string>() + '"';
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const json& number : value) text += (text.empty() ? "" : " ") + cell(number);
  return text;
}

}  // namespace

std::string planText(const TrustPlan& plan) {
  json text = {{"gaps", plan.gaps},
               {"stride", plan.stride},
               {"scenes", plan.scenes},
               {"drawn_pairs", plan.drawn_pairs},
               {"options", optionsJson(plan.pipelines.front())}};
  text["sets"] = text["methods"] = json::array();
  for (const TrustSet& set : plan.sets) {
    text["sets"].push_back({{"name", setName(set.path)},
                            {"truth_rotation_sigma_deg", kDegrees * set.noise.rotation},
                            {"truth_translation_sigma_m", set.noise.translation}});
  }
  for (const MatchFilterOptions& pipeline : plan.pipelines) text["methods"].push_back(pipeline.method);
  return text.dump();
}

std::string runsText(const std::vector<TrustRow>& rows) {
  json runs = json::array();
  for (const TrustRow& row : rows) {
    json run;
    forEachColumn(row, [&run](const char* name, const auto& field) { run[name] = toJson(field); });
    runs.push_back(std::move(run));
  }
  return runs.dump();
}

std::vector<TrustRow> trustRowsOf(const std::string& runs) {
  std::vector<TrustRow> rows;
  for (const json& run : json::parse(runs)) {
    TrustRow row;
    forEachColumn(row, [&run](const char* name, auto& field) { fromJson(run.at(name), field); });
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string trustCsv(const std::vector<TrustRow>& rows) {
  std::ostringstream csv;
  const auto separator = [](const char* name) { return name == std::string("kind") ? "" : ","; };
  const TrustRow columns{};
  forEachColumn(columns, [&](const char* name, const auto&) { csv << separator(name) << name; });
  csv << '\n';
  for (const TrustRow& row : rows) {
    forEachColumn(row, [&](const char* name, const auto& field) { csv << separator(name) << cell(toJson(field)); });
    csv << '\n';
  }
  return csv.str();
}

}  // namespace gms_ransac
