#include "tables/tables_json.h"

#include "run/options_json.h"

namespace gms_ransac {

namespace {

using nlohmann::json;

json toJson(const Measurement& m) {
  return {{"unit", m.unit},
          {"sequence", m.sequence},
          {"pair", m.pair},
          {"preset", m.preset},
          {"method", m.method},
          {"model", m.model},
          {"ratio", m.ratio},
          {"matches_raw", m.matches_raw},
          {"matches_gms", m.matches_gms},
          {"detect_ms", m.detect_ms},
          {"match_ms", m.match_ms},
          {"gms_ms", m.gms_ms},
          {"raw_points", m.raw_points},
          {"inliers", m.inliers},
          {"known", m.known},
          {"correct", m.correct},
          {"points", m.points},
          {"hypotheses", m.hypotheses},
          {"models_scored", m.models_scored},
          {"point_evaluations", m.point_evaluations},
          {"ransac_ms", m.ransac_ms},
          {"rotation_error", m.rotation_error},
          {"pose_error", m.pose_error}};
}

Measurement measurementFromJson(const json& line) {
  Measurement m;
  line.at("unit").get_to(m.unit);
  line.at("sequence").get_to(m.sequence);
  line.at("pair").get_to(m.pair);
  line.at("preset").get_to(m.preset);
  line.at("method").get_to(m.method);
  line.at("model").get_to(m.model);
  line.at("ratio").get_to(m.ratio);
  line.at("matches_raw").get_to(m.matches_raw);
  line.at("matches_gms").get_to(m.matches_gms);
  line.at("detect_ms").get_to(m.detect_ms);
  line.at("match_ms").get_to(m.match_ms);
  line.at("gms_ms").get_to(m.gms_ms);
  line.at("raw_points").get_to(m.raw_points);
  line.at("inliers").get_to(m.inliers);
  line.at("known").get_to(m.known);
  line.at("correct").get_to(m.correct);
  line.at("points").get_to(m.points);
  line.at("hypotheses").get_to(m.hypotheses);
  line.at("models_scored").get_to(m.models_scored);
  line.at("point_evaluations").get_to(m.point_evaluations);
  line.at("ransac_ms").get_to(m.ransac_ms);
  line.at("rotation_error").get_to(m.rotation_error);
  line.at("pose_error").get_to(m.pose_error);
  return m;
}

}  // namespace

std::string planText(const TablesPlan& plan) {
  const json text = {{"sequences", plan.sequences},
                     {"gap", plan.gap},
                     {"pairs", plan.pairs},
                     {"repeats", plan.repeats},
                     {"presets", plan.presets},
                     {"ratios", plan.ratios},
                     {"methods", plan.methods},
                     {"threads", plan.base.extractor.threads},
                     {"options", optionsJson(plan.base)}};
  return text.dump();
}

std::string runsText(const std::vector<Measurement>& measurements) {
  json runs = json::array();
  for (const Measurement& measurement : measurements) runs.push_back(toJson(measurement));
  return runs.dump();
}

std::vector<Measurement> measurementsOf(const std::string& runs) {
  std::vector<Measurement> measurements;
  for (const json& run : json::parse(runs)) measurements.push_back(measurementFromJson(run));
  return measurements;
}

}  // namespace gms_ransac
