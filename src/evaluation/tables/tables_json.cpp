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

}  // namespace gms_ransac
