#include "reconfigure.h"

#include <sstream>
#include <stdexcept>
#include <utility>

#include <XmlRpcValue.h>
#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>
#include <boost/thread/recursive_mutex.hpp>

#include "match_filter_config.h"
#include "refusal.h"

namespace gms_ransac {

namespace {

/// One reconfigurable number and what it may be.
struct Range {
  bool whole;
  double low, high;

  bool holds(double value) const { return value >= low && value <= high; }  // not of NaN
  std::string text() const {
    std::ostringstream out;
    out << (whole ? "a whole number" : "a number") << " between ";
    // At six digits 2147483647 would be another number.
    whole ? out << static_cast<int>(low) << " and " << static_cast<int>(high) : out << low << " and " << high;
    return out.str();
  }
};

using Description = MatchFilterConfig::AbstractParamDescription;

double numberIn(const Description& description, const MatchFilterConfig& config) {
  boost::any value;
  description.getValue(config, value);
  return description.type == "int" ? boost::any_cast<int>(value) : boost::any_cast<double>(value);
}

bool isNumber(const Description& description) { return description.type == "int" || description.type == "double"; }

/// The words that cfg/MatchFilter.cfg offers; it keeps them in the text from which rqt_reconfigure makes its menu.
std::vector<std::string> choicesOf(const Description& description) {
  std::vector<std::string> words;
  const std::string key = "'value': '";
  const std::string& menu = description.edit_method;
  for (size_t at = menu.find(key); at != std::string::npos; at = menu.find(key, at)) {
    at += key.size();
    words.push_back(menu.substr(at, menu.find('\'', at) - at));
  }
  return words;
}

Range rangeOf(const Description& description) {
  return {description.type == "int", numberIn(description, MatchFilterConfig::__getMin__()),
          numberIn(description, MatchFilterConfig::__getMax__())};
}

ProcessorOptions processorOptions(const MatchFilterConfig& config, int threads) {
  ProcessorOptions options;
  options.core = coreOptions(config);
  // The second thread runs beside the first, image after image; the third and the fourth share the work of each.
  options.core.extractor.threads = threads >= 3 ? 2 : 1;
  options.core.matcher_threads = threads >= 4 ? 2 : 1;
  options.max_frame_gap = config.max_frame_gap;
  options.hold_reference = config.hold_reference;
  options.sigma_floor = {config.translation_sigma_floor, config.rotation_sigma_floor};
  return options;
}

RuntimeOptions runtimeOptions(const MatchFilterConfig& config, int threads) {
  RuntimeOptions options;
  options.processor = processorOptions(config, threads);
  options.outputs.publish_rejected = config.publish_rejected;
  options.outputs.publish_relative_tf = config.publish_relative_tf;
  options.outputs.publish_odom_tf = config.publish_odom_tf;
  options.outputs.features = {config.feature_limit, config.feature_distance};
  return options;
}

}  // namespace

std::vector<std::string> reconfigurableNames() {
  std::vector<std::string> names;
  for (const auto& description : MatchFilterConfig::__getParamDescriptions__()) names.push_back(description->name);
  return names;
}

void checkConfigOnServer(const ros::NodeHandle& pnh) {
  for (const auto& description : MatchFilterConfig::__getParamDescriptions__()) {
    XmlRpc::XmlRpcValue raw;
    if (!pnh.getParam(description->name, raw)) continue;
    if (isNumber(*description)) {
      const Range range = rangeOf(*description);
      const bool is_int = raw.getType() == XmlRpc::XmlRpcValue::TypeInt;
      const bool fits = is_int || (raw.getType() == XmlRpc::XmlRpcValue::TypeDouble && !range.whole);
      if (!fits || !range.holds(is_int ? static_cast<int>(raw) : static_cast<double>(raw))) {
        refuse(pnh, description->name, toText(raw), range.text());
      }
    } else if (description->type == "bool" && raw.getType() != XmlRpc::XmlRpcValue::TypeBoolean) {
      refuse(pnh, description->name, toText(raw), "true or false");
    } else if (description->type == "str") {
      const std::vector<std::string> choices = choicesOf(*description);
      if (raw.getType() != XmlRpc::XmlRpcValue::TypeString || !contains(choices, toText(raw))) {
        refuse(pnh, description->name, toText(raw), oneOf(choices));
      }
    }
  }
}

void UnclampedConfig::__clamp__() {
  problem.clear();
  for (const auto& description : __getParamDescriptions__()) {
    std::ostringstream asked;
    std::string accepted;
    if (isNumber(*description)) {
      const Range range = rangeOf(*description);
      const double value = numberIn(*description, *this);
      if (range.holds(value)) continue;
      range.whole ? asked << static_cast<int>(value) : asked << value;
      accepted = range.text();
    } else if (description->type == "str") {
      boost::any value;
      description->getValue(*this, value);
      asked << boost::any_cast<std::string>(value);
      const std::vector<std::string> choices = choicesOf(*description);
      if (contains(choices, asked.str())) continue;
      accepted = oneOf(choices);
    } else {
      continue;
    }
    if (!problem.empty()) problem += "; ";
    problem += refusal("~" + description->name, asked.str(), accepted);
  }
}

MatchFilterOptions coreOptions(const MatchFilterConfig& config) {
  MatchFilterOptions options;
  options.method = config.method;
  options.extractor.extractor = config.extractor;
  options.extractor.features = config.features;
  options.extractor.levels = config.pyramid_levels;
  options.extractor.scale_factor = config.pyramid_scale;
  options.extractor.fast_threshold = config.fast_threshold;
  options.motion_statistics.acceptance = parseAcceptance(config.gms_acceptance);
  options.motion_statistics.grid_columns = config.gms_grid_columns;
  options.motion_statistics.grid_rows = config.gms_grid_rows;
  options.motion_statistics.threshold_factor = config.gms_threshold_factor;
  options.motion_statistics.rotation = config.gms_rotation;
  options.motion_statistics.scale = config.gms_scale;
  if (config.gms_border != "opencv" && config.gms_border != "original") {
    throw std::invalid_argument("gms_border is '" + config.gms_border + "'; it must be 'opencv' or 'original'");
  }
  options.motion_statistics.border = config.gms_border == "opencv" ? GridBorder::kOpenCV : GridBorder::kOriginal;
  options.distance_reading = parseDistanceReading(config.distance_reading);
  options.one_to_one = config.one_to_one;
  options.lan_mutual = config.lan_mutual;
  options.second_alpha = config.lan_second_alpha;
  options.robust.model = parseModelType(config.model);
  options.robust.threshold_px = config.threshold_px;
  options.robust.confidence = config.confidence;
  options.robust.max_iterations = config.max_iterations;
  options.robust.seed = static_cast<uint64_t>(config.seed);
  options.robust.ratio = config.ratio;
  options.robust.geometric_groups = config.geometric_groups;
  options.robust.tdd_d = config.tdd_d;
  options.robust.subset_count = config.subset_count;
  options.robust.subset_fraction = config.subset_fraction;
  options.robust.split = config.split;
  options.robust.target_ratio = config.target_ratio;
  options.robust.quality = config.quality;
  options.robust.judge = config.judge;
  options.robust.refine = config.refine;
  options.validate();
  return options;
}

struct Reconfigure::Server {
  Server(const ros::NodeHandle& handle, const std::string& log_name, int threads_of_node)
      : pnh(handle), name(log_name), threads(threads_of_node), server(mutex, handle) {}

  void change(UnclampedConfig& config) {
    try {
      if (!config.problem.empty()) throw std::invalid_argument(config.problem);
      accept(runtimeOptions(config, threads));
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM(name << ": change refused, the old parameters stay: " << error.what());
      config = in_force;
      return;
    }
    in_force = config;
  }

  const ros::NodeHandle pnh;
  const std::string name;
  const int threads;
  Accept accept;
  MatchFilterConfig in_force;  ///< what a refused change falls back to; guarded by the mutex
  boost::recursive_mutex mutex;
  dynamic_reconfigure::Server<UnclampedConfig> server;
};

Reconfigure::Reconfigure(const ros::NodeHandle& pnh, const std::string& name, int threads)
    : server_(std::make_unique<Server>(pnh, name, threads)) {}

Reconfigure::~Reconfigure() = default;

RuntimeOptions Reconfigure::startOptions() {
  // Refused here, with a sentence; dynamic_reconfigure would only log them.
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  config.__fromServer__(server_->pnh);
  RuntimeOptions options = runtimeOptions(config, server_->threads);
  server_->in_force = config;
  return options;
}

void Reconfigure::serve(Accept accept) {
  server_->accept = std::move(accept);
  server_->server.setCallback(
      [server = server_.get()](UnclampedConfig& config, uint32_t /*level*/) { server->change(config); });
}

}  // namespace gms_ransac
