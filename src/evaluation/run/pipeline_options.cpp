#include "run/pipeline_options.h"

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "program.h"

namespace gms_ransac {

namespace po = boost::program_options;

void PipelineArguments::addTo(po::options_description& description, const std::vector<std::string>& given) {
  if (std::find(given.begin(), given.end(), "--paper") != given.end()) base = MatchFilterOptions::paper();
  FeatureExtractorOptions& extractor = base.extractor;
  MotionStatisticsOptions& gms = base.motion_statistics;
  RobustOptions& robust = base.robust;
  auto add = description.add_options();
  add("paper", "the paper's method and settings, literally, where no option says otherwise");
  add("method,m", po::value(&methods)->composing(), "method, or several with commas between (see evaluate --list)");
  add("model", po::value(&model)->default_value(model), "essential, fundamental or homography");
  add("extractor", po::value(&extractor.extractor)->default_value(extractor.extractor), "simd_orb or opencv");
  add("features", po::value(&extractor.features)->default_value(extractor.features), "keypoints asked for per image");
  add("fast-threshold", po::value(&extractor.fast_threshold)->default_value(extractor.fast_threshold),
      "FAST contrast, grey levels; 0 is usual above 3000 features");
  add("levels", po::value(&extractor.levels)->default_value(extractor.levels), "pyramid levels");
  add("scale-factor", po::value(&extractor.scale_factor)->default_value(extractor.scale_factor), "between levels");
  add("grid", po::value(&grid), "cells of the motion statistics, COLUMNSxROWS; 0x0: the method's own");
  add("alpha", po::value(&gms.threshold_factor)->default_value(gms.threshold_factor),
      "threshold factor of GMS; 0: the method's own");
  add("acceptance", po::value(&acceptance)->default_value(acceptance),
      "matches GMS keeps: own (the method's), threshold (as published) or evidence (as lo_prosac)");
  add("distance-reading", po::value(&distance_reading)->default_value(distance_reading),
      "gms_dist_ransac: displacement or pairwise");
  add("one-to-one", po::value(&base.one_to_one)->default_value(base.one_to_one),
      "keep one match of each current point; 0: all, as in the paper");
  add("lan-mutual", po::value(&base.lan_mutual)->default_value(base.lan_mutual), "lan: match in both directions");
  add("second-alpha", po::value(&base.second_alpha)->default_value(base.second_alpha),
      "lan: threshold factor of the final check; 0: scaled by the share kept");
  add("rotation", po::bool_switch(&gms.rotation), "GMS: try all rotations");
  add("scale", po::bool_switch(&gms.scale), "GMS: try other scales");
  add("threshold", po::value(&threshold), "inlier threshold, pixels (default 1; homography 3)");
  add("confidence", po::value(&robust.confidence)->default_value(robust.confidence), "of a clean sample");
  add("max-iterations", po::value(&robust.max_iterations)->default_value(robust.max_iterations), "cap on samples");
  add("ratio", po::value(&robust.ratio)->default_value(robust.ratio), "cp_ransac: share of the confident group");
  add("quality", po::value(&robust.quality)->default_value(robust.quality),
      "ordered methods: score, support, distance or ratio instead of the method's own");
  add("judge", po::value(&robust.judge)->default_value(robust.judge),
      "judge the answer (spread, parallax, other motions); 0: what was found stands, as in the papers");
  add("refine", po::value(&robust.refine)->default_value(robust.refine),
      "robust least squares on the final model; 0: textbook");
  add("seed", po::value(&robust.seed)->default_value(robust.seed), "same seed, same result");
  add("threads", po::value(&threads)->default_value(threads), "of extraction and matching");
}

MatchFilterOptions PipelineArguments::options(const std::string& method) const {
  MatchFilterOptions result = base;
  result.method = method;
  result.robust.model = parseModelType(model);
  result.motion_statistics.acceptance = parseAcceptance(acceptance);
  result.distance_reading = parseDistanceReading(distance_reading);
  const std::string& extractor = base.extractor.extractor;
  result.extractor.extractor = currentName("--extractor", extractor, currentExtractorName(extractor));
  result.extractor.threads = threads;
  result.matcher_threads = std::clamp(threads, 1, 2);
  if (!threshold.empty()) {
    std::istringstream stream(threshold);
    if (!(stream >> result.robust.threshold_px) || !stream.eof() || result.robust.threshold_px <= 0) {
      throw std::invalid_argument("--threshold is '" + threshold + "'; it must be a positive number of pixels");
    }
  }
  if (!grid.empty()) {
    int& columns = result.motion_statistics.grid_columns;
    int& rows = result.motion_statistics.grid_rows;
    char end = 0;
    if (std::sscanf(grid.c_str(), "%dx%d%c", &columns, &rows, &end) != 2) {
      throw std::invalid_argument("--grid is '" + grid + "'; it must look like 20x20");
    }
  }
  result.validate();
  return result;
}

std::vector<std::string> PipelineArguments::methodNames() const {
  if (methods.empty()) return {base.method};
  return parseMethodNames(methods);
}

nlohmann::json pipelineJson(const MatchFilterOptions& options) {
  const MotionStatisticsOptions& gms = options.motion_statistics;
  return {{"extractor", options.extractor.extractor},
          {"levels", options.extractor.levels},
          {"scale_factor", options.extractor.scale_factor},
          {"fast_threshold", options.extractor.fast_threshold},
          {"grid", {gms.grid_columns, gms.grid_rows}},
          {"alpha", gms.threshold_factor},
          {"rotation", gms.rotation},
          {"scale", gms.scale},
          {"threshold_px", options.robust.threshold_px},
          {"confidence", options.robust.confidence},
          {"max_iterations", options.robust.max_iterations},
          {"refine", options.robust.refine},
          {"judge", options.robust.judge},
          {"quality", options.robust.quality},
          {"acceptance", static_cast<int>(gms.acceptance)},
          {"distance_reading", static_cast<int>(options.distance_reading)},
          {"one_to_one", options.one_to_one},
          {"lan_mutual", options.lan_mutual},
          {"second_alpha", options.second_alpha},
          {"threads", options.extractor.threads},
          {"seed", options.robust.seed}};
}

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

std::vector<std::string> parseMethodNames(const std::vector<std::string>& given) {
  std::vector<std::string> names;
  for (const std::string& list : given) {
    if (list.empty()) findMethod(list);  // complains with the list of known names
    for (const std::string& name : splitAtCommas(list))
      names.push_back(currentName("--method", name, findMethod(name).name));
  }
  return names;
}

std::string methodTable() {
  std::ostringstream text;
  for (const MethodEntry& method : methods()) {
    text << method.name << "\n    " << method.source << ": " << method.summary << "\n";
  }
  return text.str();
}

}  // namespace gms_ransac
