#include "trust/trust_json.h"

#include <cmath>
#include <utility>

#include "run/metrics.h"
#include "run/options_json.h"

namespace gms_ransac {

namespace {

using nlohmann::json;

using Columns = std::vector<std::pair<const char*, json>>;

json toJson(const Reliability& reliability) {
  json numbers = json::array();
  for (const Reliability::Bin& bin : reliability.bins) {
    numbers.push_back(bin.count);
    numbers.push_back(std::round(1e4 * bin.probability) / 1e4);
    numbers.push_back(bin.right);
  }
  return numbers;
}

/// In the order of the file. What is no number becomes null in text.
Columns columnsOf(const TrustRow& row) {
  return {
      {"kind", row.kind},
      {"set", row.set},
      {"gap", row.gap},
      {"pair", row.pair},
      {"method", row.method},
      {"status", row.status},
      {"survivors", row.survivors},
      {"inliers", row.inliers},
      {"has_truth", row.has_truth},
      {"baseline_m", row.baseline_m},
      {"moved", row.moved},
      {"right", row.right},
      {"wrong", row.wrong},
      {"rotation_error_deg", row.rotation_error_deg},
      {"direction_error_deg", row.direction_error_deg},
      {"rx_deg", row.rx_deg},
      {"ry_deg", row.ry_deg},
      {"rz_deg", row.rz_deg},
      {"rotation_sigma_deg", row.rotation_sigma_deg},
      {"direction_sigma_deg", row.direction_sigma_deg},
      {"uncertainty_deg", row.uncertainty_deg},
      {"nees_rotation", row.nees_rotation},
      {"nees_direction", row.nees_direction},
      {"parallax_px", row.parallax_px},
      {"sigma_px", row.sigma_px},
      {"covariance", row.covariance},
      {"reliability", toJson(row.reliability)},
  };
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
                            {"truth_translation_sigma_m", set.noise.translation},
                            {"truth_clock_sigma_s", set.noise.clock},
                            {"truth_alignment_sigma_deg", kDegrees * set.noise.alignment}});
  }
  for (const MatchFilterOptions& pipeline : plan.pipelines) text["methods"].push_back(pipeline.method);
  return text.dump();
}

std::string runsText(const std::vector<TrustRow>& rows) {
  json runs = json::array();
  for (const TrustRow& row : rows) {
    json run;
    for (auto& [name, value] : columnsOf(row)) run[name] = std::move(value);
    runs.push_back(std::move(run));
  }
  return runs.dump();
}

std::string trustCsv(const std::vector<std::string>& runs) {
  const Columns columns = columnsOf(TrustRow());
  std::string csv;
  for (const auto& column : columns) csv += (csv.empty() ? "" : ",") + std::string(column.first);
  for (const std::string& text : runs) {
    for (const json& run : json::parse(text)) {
      char separator = '\n';
      for (const auto& column : columns) {
        csv += separator + cell(run.at(column.first));
        separator = ',';
      }
    }
  }
  return csv + '\n';
}

}  // namespace gms_ransac
